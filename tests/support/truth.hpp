#pragma once
// How far a merge is from the truth of a recording.

#include <filesystem>
#include <string>
#include <vector>

#include "common/geometry/se3.hpp"

namespace headframe::test {

/// Reported poses of a session and the true ones in the recording's world, scan by scan.
struct TruePath {
  std::vector<Pose> T_local_sensor;
  std::vector<Pose> T_world_sensor;
};

/// From RECORDING/ROBOT/poses.txt, and RECORDING/truth/ROBOT.txt or, where there is none, truth.json's transform of the
/// frame.
TruePath read_true_path(const std::filesystem::path& recording, const std::string& robot);

struct OverlapError {
  std::size_t pairs = 0;  // of poses of both sessions that are truly within near_m
  double translation_m = -1;
  double rotation_deg = -1;
};

/// Medians over those pairs of the estimated relative pose (reported poses and T_a_b) against the true one.
OverlapError overlap_error(const TruePath& a, const TruePath& b, const Pose& T_a_b, double near_m = 8);

/// The same for sessions whose paths may never come that near: where they do not, of poses within 16 m, else 30 m.
OverlapError nearest_overlap_error(const TruePath& a, const TruePath& b, const Pose& T_a_b);

}  // namespace headframe::test
