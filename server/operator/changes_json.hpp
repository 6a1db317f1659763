#pragma once

#include "server/atlas/change_list.hpp"
#include "server/operator/json_text.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// The changes in the form that the API uses; `sessions` gives the names of their ids.
Json changes_array(const std::vector<PlacedChange>& changes, const std::vector<SessionRow>& sessions);

/// The changes between all merged sessions since a time, in seconds since 1970.
std::string changes_json(const AtlasView& view, const std::vector<SessionRow>& sessions, double since_s);

}  // namespace headframe
