// ./run bench: figures as ratios against a reference in the same run, as a table and as JSON.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/convert.hpp"
#include "server/place/wall_search.hpp"
#include "tests/bench/basin.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/registration.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::bench {
namespace {

/// Median over the runs, after one that is not counted.
template <class Work>
double median_ms(int runs, Work&& work) {
  std::vector<double> ms;
  for (int i = 0; i <= runs; ++i) {
    const double once = wall_ms(work);
    if (i > 0) ms.push_back(once);
  }
  return median(ms);
}

nlohmann::json link_bytes() {
  const test::BoxMine mine({test::BoxMine::drift(0, 0, 80, 0), test::BoxMine::drift(30, 0, 30, 40)});
  const auto drive = test::drive(mine, {{2, 0}, {30, 0}, {30, 38}}, 0, 1);
  std::size_t keyframe_bytes = 0, cloud_bytes = 0, points = 0;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
    v1::RobotMessage message;
    *message.mutable_keyframe() = to_proto(drive.keyframes[i]).value();
    keyframe_bytes += message.ByteSizeLong() + 4;
    cloud_bytes += encode_cloud(drive.clouds[i]).value().size();
    points += point_count(drive.clouds[i]);
  }
  const double per_keyframe = static_cast<double>(keyframe_bytes) / static_cast<double>(drive.keyframes.size());
  const double per_point = static_cast<double>(cloud_bytes) / static_cast<double>(points);
  std::printf("link\n  %.0f bytes a keyframe with its frame; clouds %.2f bytes a point at 1 cm\n", per_keyframe,
              per_point);
  return {{"bytes_per_keyframe", per_keyframe}, {"bytes_per_point", per_point}};
}

nlohmann::json walls() {
  const test::BoxMine mine(
      {test::BoxMine::drift(0, 0, 120, 0), test::BoxMine::drift(30, 0, 30, 60), test::BoxMine::drift(80, -40, 80, 0)});
  const auto a = test::drive(mine, {{2, 0}, {30, 0}, {30, 58}}, 0, 1), b = test::drive(mine, {{118, 0}, {2, 0}}, 1, 2);
  const WallMap map_a = draw_wall_map(a.keyframes, 1), map_b = draw_wall_map(b.keyframes, 1);
  const double ms = median_ms(5, [&] { search_walls(map_a, map_b, 20, 2); });
  std::printf("places\n  one pair of wall maps over all shifts and turns: %.0f ms (2 threads)\n", ms);
  return {{"wall_search_ms", ms}};
}

}  // namespace
}  // namespace headframe::bench

int main(int argc, char** argv) {
  using namespace headframe::bench;
  const std::string what = argc > 1 ? argv[1] : "all";
  const std::filesystem::path recordings = argc > 2 ? argv[2] : "../shared/data", out = "build/bench";
  std::filesystem::create_directories(out);
  bool known = false;
  const auto part = [&](const char* name, auto&& measure) {
    if (what != "all" && what != name) return;
    known = true;
    nlohmann::json figures = measure();
    if (!figures.contains(name)) figures = {{name, figures}};
    std::ofstream(out / (std::string(name) + ".json")) << figures.dump(1) << "\n";
  };
  part("registration", [&] {
    nlohmann::json figures;
    figures["registration"] = registration(recordings);
    figures["sampling"] = sampling();
    return figures;
  });
  part("link", [] { return link_bytes(); });
  part("places", [] { return walls(); });
  if (what == "basin") part("basin", [&] { return basin(out); });  // minutes: only when asked for
  if (!known)
    std::fprintf(stderr, "headframe-bench: no bench '%s'; there are: registration, link, places, basin, all\n",
                 what.c_str());
  return known ? 0 : 2;
}
