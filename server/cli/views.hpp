#pragma once
// What the command prints of the API's JSON. Throws nlohmann::json::exception when the JSON is not the API's.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace headframe {

/// Tables fit into width cells; 0: no limit.
std::string status_view(const nlohmann::json& status);
std::string sessions_view(const nlohmann::json& sessions, std::size_t width);
std::string atlas_view(const nlohmann::json& atlas, std::size_t width);

std::string alignments_view(const nlohmann::json& alignments, std::size_t width);
std::string changes_view(const nlohmann::json& changes, std::size_t width);
/// One line: what became of the alignment that was decided on.
std::string decision_view(const nlohmann::json& decided);

std::string explanation_view(const nlohmann::json& explanation);

std::string survey_view(const nlohmann::json& survey, std::size_t width);
std::string surveys_view(const nlohmann::json& surveys, std::size_t width);
/// How much room there is, and which clouds may go.
std::string store_view(const nlohmann::json& store, std::size_t width);
/// Which server serves, and which wait.
std::string servers_view(const nlohmann::json& servers, std::size_t width);
/// A line, and a table of the sessions that clouds go of; empty: none may go.
std::string covered_view(const nlohmann::json& covered, std::size_t width);
/// How far the surfaces lie apart, as bars.
std::string overlay_view(const nlohmann::json& overlay);

/// "2 attempts, 5 keyframes, 1 submap", without what is zero; "nothing".
std::string pending_view(const nlohmann::json& pending);

}  // namespace headframe
