#pragma once
// What happened at the station, told as the difference of two looks at it. Pure.

#include <string>
#include <vector>

#include "server/station/station.hpp"

namespace headframe {

struct StationLook {
  std::vector<SessionRow> sessions;
  AtlasView view;
  Pending pending;
};

/// Asks the station; quick.
StationLook look_at(const Station& station);

/// One JSON object for each thing that happened, its "type" first: robot_connected, robot_left, keyframes (also of a
/// new session), renamed, alignment (new, or another state, decision, placement or probability), revision, pending.
/// What came and went between two looks is not told.
std::vector<std::string> events_between(const StationLook& before, const StationLook& after);

/// The whole look as one event of type "snapshot": sessions, atlas, pending.
std::string snapshot_event(const StationLook& look);

}  // namespace headframe
