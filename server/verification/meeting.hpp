#pragma once
// Where two sessions meet when one is laid on the other: counted in keyframes and in path.

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "server/verification/evidence.hpp"
#include "server/verification/judge_config.hpp"

namespace headframe {

/// A keyframe with a cloud: its number in its session, and where it stood in the local frame.
struct KeyframePosition {
  std::size_t keyframe = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

/// The position nearest to a point, of one frame.
struct NearestPosition {
  const KeyframePosition* position = nullptr;  // null: there is none
  double distance_m = std::numeric_limits<double>::max();
};
NearestPosition nearest_to(std::span<const KeyframePosition> positions, const Eigen::Vector3d& p);

/// Where to look first: the keyframe of b nearest to p_b that comes near a, and the one of a nearest to it; where their
/// paths never meet, those nearest to p_b. Nothing when they lie too far apart.
struct Meeting {
  std::size_t keyframe_a = 0, keyframe_b = 0;
};
std::optional<Meeting> first_meeting(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                     const Pose& T_a_b_0, const Eigen::Vector3d& p_b, const JudgeConfig& config);

/// Positions of b that come within reach of one of a's.
std::vector<KeyframePosition> near_other(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                         const Pose& T_a_b, double reach_m);

/// Where an overlap is judged besides p_b: keyframes of b, those nearest to a's path first, as far from p_b and from
/// each other as can be.
std::vector<KeyframePosition> other_places(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                           const Pose& T_a_b, const Eigen::Vector3d& p_b, const JudgeConfig& config);

/// Sets Evidence::pairs and overlap_m: how many keyframes of a and b come near the other path, and along how much of
/// both paths the other passes.
void measure_overlap(Evidence& evidence, std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                     const Pose& T_a_b, const JudgeConfig& config);

}  // namespace headframe
