#pragma once
// Recognises changes of the mine: patches where free space contradicts a placement because rock was removed or added in
// the time between two sessions.

#include <optional>
#include <span>
#include <vector>

#include "server/verification/change.hpp"
#include "server/verification/free_space.hpp"
#include "server/verification/recorded.hpp"

namespace headframe {

/// The rock of one session and what the other session's rays say of it, in a common frame.
struct AskedRock {
  Points points;
  std::vector<PointSight> sights;  // one for each point
};

/// Which of two recordings is newer, and when it changed.
struct Dates {
  bool a_is_newer = false;
  double older_s = 0, newer_s = 0;  // the end of the older, the beginning of the newer
};
/// Nullopt if one of them has no date or less than an hour lies between them: then the mine counts as unchanged.
std::optional<Dates> dates_of(const Recorded& a, const Recorded& b);

/// Violated points that form a patch with an edge: compact, dense inside, and surrounded by rock on which both sessions
/// agree. A wrong placement, in contrast, has violations everywhere.
struct ChangePatch {
  Points points;  // the violated points
  ChangeKind kind = ChangeKind::excavated;
  bool free_standing = false;  // both agree on what lies behind it, too: a machine, not a wall or a tunnel face
  Dates dates;
};

/// The patches in `a` and `b`, each holding the rock of one session as seen by the other, one point per leaf_m. Pure.
std::vector<ChangePatch> find_patches(const AskedRock& a, const AskedRock& b, float leaf_m, const Dates& dates);

/// Joins patches that touch: the same change seen from several places.
std::vector<ChangePatch> joined(std::vector<ChangePatch> patches);

/// Whether a mine may have changed like this: few changes, and those of walls and faces are all of one kind, either
/// excavated or filled. At the end of a copy, in contrast, each session passes through what is rock for the other; and
/// a wrong placement has patches everywhere.
bool plausible(std::span<const ChangePatch> changes);

Change change_of(const ChangePatch& patch);

}  // namespace headframe
