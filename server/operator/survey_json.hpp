#pragma once
// The JSON of surveys. Pure.

#include <string>
#include <string_view>

#include "server/station/station.hpp"

namespace headframe {

/// What POST /api/v1/survey has in its body: a transform, or points to find one from. bad_input says what is wrong;
/// refused: the points do not fit each other as well as they should, unless that is to be accepted.
Result<Survey> survey_from_json(std::string_view body, SessionId session, bool accept = false);

/// One survey: T_grid_session, each point with its residual, rms; T_grid_component and whether it counts there.
std::string survey_json(const Survey& survey, const Station& station);
/// All of them, the one set last at the end.
std::string surveys_json(const Station& station);

}  // namespace headframe
