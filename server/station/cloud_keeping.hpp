#pragma once
// Which clouds may be deleted to make room: those of the oldest sessions, where later ones have seen the same rock.

#include <cstdint>
#include <functional>
#include <vector>

#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/session/session_row.hpp"
#include "server/station/covered_clouds.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// What is known of the sessions at one moment.
struct KeptSessions {
  std::vector<SessionRow> rows;
  Atlas atlas;
  Corrections corrections;
  std::vector<Alignment> alignments;
};

constexpr double covered_share = 0.9;  // share of the walls around a keyframe that later sessions must have seen

/// The clouds that may be deleted, oldest session first. A cloud may be deleted if the walls around its keyframe were
/// seen by sessions of the same component that began later, have ended, and keep their clouds of them. A session keeps
/// all its clouds if it has not ended, has an alignment with one that has not, or is frozen, archived or set aside.
/// Reads keyframes from the disk; fails like the store.
Result<std::vector<CoveredClouds>> covered_clouds(Store& store, const KeptSessions& known);

/// Callbacks about the deletion.
struct LettingGo {
  std::function<void(SessionId session, const std::vector<std::uint64_t>& sequences)> gone;  // after each commit
  std::function<void(const Result<void>&)> done;                                             // once
};

/// Deletes the clouds in portions, so that acknowledgements continue in between; ends at a failure. Never blocks; calls
/// back on the store's writer thread.
void let_go(Store& store, const std::vector<CoveredClouds>& clouds, LettingGo told);

}  // namespace headframe
