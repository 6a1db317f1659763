// headframe-mine: writes recordings of robots in a mine that never was.

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/mine/picture_of.hpp"
#include "tests/mine/session_folder.hpp"
#include "tests/mine/tool.hpp"

namespace headframe::mine {
namespace {

int fail(const std::string& message) {
  std::fprintf(stderr, "headframe-mine: %s\n", message.c_str());
  return 1;
}

int generate(const Request& request, const std::string& dir, const std::string& picture_file) {
  const auto scenario = make_scenario(request);
  if (!scenario) return fail(scenario.error().message);
  std::vector<Recording> recordings;
  for (const Robot& robot : scenario->robots) recordings.push_back(record(scenario->world, robot, request.seed));
  const std::string title = std::string(to_string(request.kind)) + "-" + std::to_string(request.seed);
  if (auto ok = write_recordings(dir, title, "procedural " + title, recordings); !ok) return fail(ok.error().message);
  for (const Recording& r : recordings)
    std::printf("%s/%s: %zu scans, %.0f m, %s\n", dir.c_str(), r.robot.name.c_str(), r.scans.size(),
                length_m(r.robot.route), r.robot.lidar.name.c_str());
  if (picture_file.empty()) return 0;
  const auto drawn = picture::write_png(true_picture(title, recordings), picture_file);
  return drawn ? 0 : fail(drawn.error().message);
}

int run(int argc, char** argv) {
  CLI::App app{"Records simulated robots in a procedural mine as session folders"};
  Request request;
  std::string kind_name, dir, picture_file;
  app.add_option("--kind", kind_name, "one of " + kind_list())->required();
  app.add_option("--seed", request.seed, "same seed, same mine");
  app.add_option("--robots", request.robots, "number of drives");
  app.add_option("--overlap", request.overlap_pct,
                 "percent that a robot shares with the one before; 0: nothing at all");
  app.add_option("--length", request.length_m, "metres of each drive");
  app.add_option("--spacing", request.scan_spacing_m, "metres between scans");
  app.add_option("--sensors", request.sensors, "os1-32, vlp16-hires, hdl-32e, os0-64; given out in turn")
      ->delimiter(',');
  app.add_option("--drift", request.drift, "odometry error; 0: none, 1: about 0.5 m over 150 m");
  app.add_option("--dust", request.dust, "dust returns per metre of ray; 0.01: a haze");
  app.add_option("--out", dir, "folder to write to")->required();
  app.add_option("--picture", picture_file, "also draw the maps from above into this PNG file");
  CLI11_PARSE(app, argc, argv);
  const auto kind = kind_of(kind_name);
  if (!kind) return fail("no kind '" + kind_name + "'; there are " + kind_list());
  request.kind = *kind;
  return generate(request, dir, picture_file);
}

}  // namespace
}  // namespace headframe::mine

int main(int argc, char** argv) {
  return headframe::mine::run_tool("headframe-mine", headframe::mine::run, argc, argv);
}
