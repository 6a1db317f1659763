#pragma once
// What a robot makes of a drive, without a link: keyframes and clouds as they reach the server, with the truth beside.

#include <filesystem>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/descriptor/family.hpp"
#include "common/session/keyframe.hpp"
#include "tests/mine/scenario.hpp"
#include "tests/support/truth.hpp"

namespace headframe::bench {

struct DrivenSession {
  std::string name;   // kind-seed/robot, or data set/robot
  std::string world;  // sessions of different worlds share nothing
  FamilyId family;    // of its descriptors
  std::vector<Keyframe> keyframes = {};
  std::vector<KeyframeCloud> clouds = {};  // of keyframe i, rounded as on the wire
  test::TruePath path = {};                // of every scan
};

/// Robots of a simulated mine, and the share of rock (percent of the smaller, 0.5 m voxels) that each pair saw.
struct DrivenMine {
  std::vector<DrivenSession> sessions;
  std::vector<std::vector<double>> overlap_pct;
};
enum class Selection { by_spaciousness, every_scan };
DrivenMine drive_mine(const mine::Request& request, Selection selection = Selection::by_spaciousness);

DrivenSession drive_robot(const mine::World& world, const mine::Robot& robot, std::uint64_t seed,
                          const std::string& world_name, double first_stamp_s = 0);

/// A recorded session folder; with no truth its true path is empty. Throws when it cannot be read.
DrivenSession read_driven_session(const std::filesystem::path& recording, const std::string& robot,
                                  const DescriptorFamily& family);

}  // namespace headframe::bench
