#pragma once
// Free space that contradicts a placement, and that time explains: rock that is gone since, or that came since.

#include <optional>
#include <span>
#include <vector>

#include "server/verification/change.hpp"
#include "server/verification/free_space.hpp"
#include "server/verification/recorded.hpp"

namespace headframe {

/// The rock of one session as the other's rays found it, in a common frame.
struct AskedRock {
  Points points;
  std::vector<PointSight> sights;  // of each
};

/// Which of two recordings is the newer, and when.
struct Dates {
  bool a_is_newer = false;
  double older_s = 0, newer_s = 0;  // the end of the older, the beginning of the newer
};
/// Nothing where one has no date, or less than an hour lies between them: then nothing has changed.
std::optional<Dates> dates_of(const Recorded& a, const Recorded& b);

/// Violations that form a patch with an edge: compact, dense inside, with rock around it that both sessions agree on.
/// What is at a wrong place contradicts all along.
struct ChangePatch {
  Points points;  // that are violated
  ChangeKind kind = ChangeKind::excavated;
  bool free_standing = false;  // both agree on what lies behind it, too: a machine, not a wall or a face
  Dates dates;
};

/// Those in `a` and `b`, the rock of either as the other's rays found it, one point per leaf_m. Pure.
std::vector<ChangePatch> find_patches(const AskedRock& a, const AskedRock& b, float leaf_m, const Dates& dates);

/// Those that touch are one: the same change seen from several places.
std::vector<ChangePatch> joined(std::vector<ChangePatch> patches);

/// Whether a mine may have changed so: few changes, and walls and faces of one kind, either gone or new. Where a copy
/// of a mine ends, each session passed through what the other knows as rock; a wrong placement has patches all along.
bool plausible(std::span<const ChangePatch> changes);

Change change_of(const ChangePatch& patch);

}  // namespace headframe
