#pragma once
// Which clouds may go so that others find room: those of the oldest sessions, where later ones have seen the same rock.

#include <cstdint>
#include <functional>
#include <vector>

#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/session/session_row.hpp"
#include "server/station/covered_clouds.hpp"
#include "server/store/store.hpp"

namespace headframe {

/// What is known of the sessions, as of one moment.
struct KeptSessions {
  std::vector<SessionRow> rows;
  Atlas atlas;
  Corrections corrections;
  std::vector<Alignment> alignments;
};

constexpr double covered_share = 0.9;  // of the walls around a keyframe that later sessions have to have seen

/// The oldest session first. A cloud may go when sessions of the same component that began later and have ended have
/// seen the walls around its keyframe and keep clouds of it. What has not ended, or is tried with one that has not, is
/// frozen, archived or set aside keeps all. Reads keyframes from disk; fails as the store does.
Result<std::vector<CoveredClouds>> covered_clouds(Store& store, const KeptSessions& known);

/// Who is told what went.
struct LettingGo {
  std::function<void(SessionId session, const std::vector<std::uint64_t>& sequences)> gone;  // after each commit
  std::function<void(const Result<void>&)> done;                                             // once
};

/// Deletes them in portions, so that acknowledgements go on between; a failure ends it. Never blocks; calls back on the
/// writer's thread.
void let_go(Store& store, const std::vector<CoveredClouds>& clouds, LettingGo told);

}  // namespace headframe
