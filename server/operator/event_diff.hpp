#pragma once
// Derives what happened at the station from the difference between two snapshots of it. All functions are pure, except
// look_at().

#include <string>
#include <vector>

#include "server/station/station.hpp"

namespace headframe {

struct StationLook {
  std::vector<SessionRow> sessions;
  AtlasView view;
  Pending pending;
};

/// Takes a snapshot of the station; fast.
StationLook look_at(const Station& station);

/// One JSON object for each thing that happened, which begins with its "type": robot_connected, robot_left, keyframes
/// (a new session, or one whose number of keyframes, clouds or moves changed, or that ended or was cut), live, renamed
/// (another label, note, site, archived or frozen state), alignment (new, or another state, decision, objection,
/// placement or probability), revision, pending. A change that was reversed between the two snapshots gives no event.
std::vector<std::string> events_between(const StationLook& before, const StationLook& after);

/// The whole snapshot as one event of type "snapshot": sessions, atlas, pending.
std::string snapshot_event(const StationLook& look);

}  // namespace headframe
