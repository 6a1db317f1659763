#pragma once
// What an alignment contributes to the pose graph: loop closures between its sessions, and the placement as a whole.

#include <span>

#include "server/atlas/alignment.hpp"
#include "server/atlas/pose_constraint.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// The middle of the overlap, in b's frame: the mean of the keyframes of both that lie within 10 m of the other's path,
/// or the point half way between the nearest two. Nearly independent of which session is called a. Of long sessions
/// about a hundred keyframes each are used, evenly spaced. Zero if one has no keyframes.
Eigen::Vector3d where_they_meet(const Session& a, const Session& b, const Pose& T_a_b);

/// For a session whose keyframes were moved: the transform from where its points near the other session lie now to
/// where they lay before. Least squares over points around those of its keyframes that lay within 10 m of the other's
/// path, or around the nearest one. T_other_was: the placement before the move. Identity if one session has no
/// keyframes.
Pose T_was_now_where_they_meet(const Session& was, std::span<const Keyframe> now, const Session& other,
                               const Pose& T_other_was);

/// T_a_b according to this loop closure alone. Throws std::out_of_range if the sessions lack its keyframes.
Pose session_transform(const PoseConstraint& place, const Session& a, const Session& b);

/// The loop closures whose keyframes exist in both sessions.
std::vector<PoseConstraint> known_closures(const PoseConstraints& places, const Session& a, const Session& b);

/// The pose graph's edges for an alignment. These are the loop closures between the two sessions, unless all of them
/// are far from T_a_b and thus belong to another placement; and a weak edge at the middle of the overlap, which fixes
/// directions in which every loop closure can slide. Without loop closures the beginning and the end of the overlap
/// become edges too. Empty if the sessions have no keyframes.
std::vector<PoseConstraint> edges_of(const Alignment& alignment, const PoseConstraints& places,
                                     const SessionMap& sessions);

}  // namespace headframe
