#include <cstdio>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/convert.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::bench {

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
  std::printf("link bytes\n  %.0f bytes a keyframe with its frame; clouds %.2f bytes a point at 1 cm\n", per_keyframe,
              per_point);
  return {{"bytes_per_keyframe", per_keyframe}, {"bytes_per_point", per_point}};
}

}  // namespace headframe::bench
