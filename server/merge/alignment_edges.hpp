#pragma once
// What an alignment says of keyframes: the loop closures between its sessions, and the placement as a whole.

#include <span>

#include "server/atlas/alignment.hpp"
#include "server/atlas/pose_constraint.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// The middle of the overlap, in b's frame: the mean of the keyframes of both that lie within 10 m of the other's path,
/// or half way between the nearest two. It hardly hangs on which of the two is called a. Of a long session some
/// hundred keyframes are looked at, evenly. Zero: one has none.
Eigen::Vector3d where_they_meet(const Session& a, const Session& b, const Pose& T_a_b);

/// Where a session's past was moved: what takes a point that the session saw where it meets the other from where its
/// keyframes lie now to where they lay before. By least squares of points around all of its keyframes that lay within
/// 10 m of the other's path, or around the nearest. T_other_was: of the session as it lay. Identity: one has no
/// keyframes.
Pose T_was_now_where_they_meet(const Session& was, std::span<const Keyframe> now, const Session& other,
                               const Pose& T_other_was);

/// T_a_b that a loop closure alone tells. std::out_of_range: it is of keyframes that the sessions have not.
Pose session_transform(const PoseConstraint& place, const Session& a, const Session& b);

/// Those of keyframes that the sessions have.
std::vector<PoseConstraint> known_closures(const PoseConstraints& places, const Session& a, const Session& b);

/// For the pose graph: the loop closures between the two sessions, unless all lie elsewhere than T_a_b says and so are
/// of another placement of the pair; the middle of the overlap is another, weak one, which holds what slides at all
/// places. Where no loop closure is known, the beginning and the end of the overlap are constraints too. Empty: the
/// sessions have no keyframes.
std::vector<PoseConstraint> edges_of(const Alignment& alignment, const PoseConstraints& places,
                                     const SessionMap& sessions);

}  // namespace headframe
