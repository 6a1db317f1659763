#pragma once
// The JSON of surveys.

#include <string>
#include <string_view>

#include "server/station/station.hpp"

namespace headframe {

/// Reads the body of POST /api/v1/survey: a transform, or points from which one is fitted. bad_input: the message says
/// what is wrong; refused: the points contradict each other, and `accept` is false. Pure.
Result<Survey> survey_from_json(std::string_view body, SessionId session, bool accept = false);

/// One survey: T_grid_session, each point with its residual, the RMS, the suspected blunder, the component and
/// T_grid_component.
std::string survey_json(const Survey& survey, const Station& station);
/// All surveys; the one set last is at the end.
std::string surveys_json(const Station& station);

}  // namespace headframe
