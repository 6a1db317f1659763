#pragma once
// Where two sessions meet when one is placed on the other, in keyframes and in path.

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "server/verification/evidence.hpp"
#include "server/verification/judge_config.hpp"

namespace headframe {

/// A keyframe with a cloud: its index in its session, and its position in the local frame.
struct KeyframePosition {
  std::size_t keyframe = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

/// The position nearest to a point in the same frame.
struct NearestPosition {
  const KeyframePosition* position = nullptr;  // null: there are no positions
  double distance_m = std::numeric_limits<double>::max();
};
NearestPosition nearest_to(std::span<const KeyframePosition> positions, const Eigen::Vector3d& p);

/// The place to judge first: of b's keyframes that come near a's path, the one nearest to p_b, with the nearest
/// keyframe of a. If the paths never meet, the pair nearest to p_b. Nullopt if the two are too far apart.
struct Meeting {
  std::size_t keyframe_a = 0, keyframe_b = 0;
};
std::optional<Meeting> first_meeting(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                     const Pose& T_a_b_0, const Eigen::Vector3d& p_b, const JudgeConfig& config);

/// Positions of b within reach_m of one of a's.
std::vector<KeyframePosition> near_other(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                         const Pose& T_a_b, double reach_m);

/// The positions of a and of b that lie where the two paths meet; where they only come near each other, if they never
/// meet.
struct Overlapping {
  std::vector<KeyframePosition> a, b;
};
Overlapping overlapping(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b, const Pose& T_a_b,
                        const JudgeConfig& config);

/// Further places at which to judge an overlap, besides p_b: keyframes of b, those nearest to a's path first, as far
/// from p_b and from each other as possible.
std::vector<KeyframePosition> other_places(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                           const Pose& T_a_b, const Eigen::Vector3d& p_b, const JudgeConfig& config);

/// The first of them, JudgeConfig::further_places at most: where a placement is screened that failed at p_b.
std::vector<KeyframePosition> further_places(std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                                             const Pose& T_a_b, const Eigen::Vector3d& p_b, const JudgeConfig& config);

/// Sets Evidence::pairs and overlap_m: how many keyframes of a and b come near the other path, and the length of path
/// that they share.
void measure_overlap(Evidence& evidence, std::span<const KeyframePosition> a, std::span<const KeyframePosition> b,
                     const Pose& T_a_b, const JudgeConfig& config);

}  // namespace headframe
