// Surveys, overlays and changes for the terminal.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/cli/date.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

std::string metres(const Json& value, int decimals) { return fixed(value.get<double>(), decimals); }

}  // namespace

std::string survey_view(const Json& survey, std::size_t width) {
  const auto& T = survey.at("T_grid_session");
  const double yaw_deg = std::atan2(T.at(4).get<double>(), T.at(0).get<double>()) * 180 / M_PI;
  const std::string session =
      survey.contains("robot")
          ? printable(survey.at("robot").get<std::string>() + "/" + survey.at("session").get<std::string>())
          : "session " + survey.at("session_id").dump();
  std::string out = session + ": origin at " + metres(T.at(3), 3) + " " + metres(T.at(7), 3) + " " +
                    metres(T.at(11), 3) + " of the grid, turned by " + fixed(yaw_deg, 3) + " deg\n";
  if (survey.at("points").empty()) return out + "  given as a transform\n";
  Table table{{{"  point"}, {"x grid m", true}, {"y grid m", true}, {"z grid m", true}, {"off by m", true}}, {}};
  for (const Json& point : survey.at("points")) {
    const Json& p = point.at("p_grid");
    table.rows.push_back({"  " + printable(point.at("name").get<std::string>()), metres(p.at(0), 3), metres(p.at(1), 3),
                          metres(p.at(2), 3), metres(point.at("residual_m"), 3)});
  }
  out += table.text(width) + "  rms " + metres(survey.at("rms_m"), 3) + " m\n";
  if (const Json suspect = survey.value("suspect", Json()); suspect.is_object())
    out += "  " + printable(suspect.at("text").get<std::string>()) + "\n";
  return out;
}

std::string surveys_view(const Json& surveys, std::size_t width) {
  if (surveys.at("surveys").empty()) return "no survey yet: headframe survey set SESSION FILE\n";
  std::string out;
  for (const Json& survey : surveys.at("surveys")) out += survey_view(survey, width);
  return out;
}

std::string overlay_view(const Json& overlay) {
  constexpr double bar_cells = 50;
  const double bin_m = overlay.at("bin_m").get<double>();
  const auto counts = overlay.at("residuals_m").get<std::vector<double>>();
  const double most = std::max(1.0, counts.empty() ? 0.0 : *std::max_element(counts.begin(), counts.end()));
  Table table{{{"from m", true}, {"points", true}, {""}}, {}};
  for (std::size_t i = 0; i < counts.size(); ++i)
    table.rows.push_back({fixed(static_cast<double>(i) * bin_m, 2), fixed(counts[i], 0),
                          std::string(static_cast<std::size_t>(std::lround(bar_cells * counts[i] / most)), '#')});
  std::string out = "how far b's points lie from a's surface\n" + table.text(0);
  out += overlay.at("unmatched").dump() + " points of b have no surface of a within half a metre\n";
  const Json& rival = overlay.at("runner_up");
  if (rival.is_object()) {
    const auto& T = rival.at("T_a_b");
    out += "runner-up: x " + metres(T.at(3), 1) + ", y " + metres(T.at(7), 1) + " m, probability " +
           metres(rival.at("probability"), 3) + "\n";
  }
  return out;
}

std::string changes_view(const Json& changes, std::size_t width) {
  if (changes.at("changes").empty())
    return "no change: sessions tell that are merged, more than an hour apart, with stamps that are dates\n";
  Table table{{{"what"},
               {"component", true, 3},
               {"x m", true},
               {"y m", true},
               {"z m", true},
               {"size m", true},
               {"before"},
               {"by", false, 2},
               {"since"},
               {"by", false, 1}},
              {}};
  for (const Json& c : changes.at("changes")) {
    const Json &p = c.at("p"), &size = c.at("size_m");
    const auto named = [](const Json& s) {
      return printable(s.at("robot").get<std::string>() + "/" + s.at("session").get<std::string>());
    };
    table.rows.push_back({c.at("kind").get<std::string>(), c.at("component").is_null() ? "-" : c.at("component").dump(),
                          metres(p.at(0), 1), metres(p.at(1), 1), metres(p.at(2), 1),
                          metres(size.at(0), 1) + " x " + metres(size.at(1), 1) + " x " + metres(size.at(2), 1),
                          date_of(c.at("older").at("stamp_s").get<double>()), named(c.at("older")),
                          date_of(c.at("newer").at("stamp_s").get<double>()), named(c.at("newer"))});
  }
  return table.text(width);
}

}  // namespace headframe
