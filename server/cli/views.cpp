#include "server/cli/views.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "server/cli/date.hpp"
#include "server/cli/table.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

std::string name(const Json& key) {
  return printable(key.at("robot").get<std::string>()) + "/" + printable(key.at("session").get<std::string>());
}

/// With the operator's label, if there is one.
std::string labelled(const Json& session) {
  const Json label = session.value("label", Json());
  return name(session) + (label.is_string() ? " (" + printable(label.get<std::string>()) + ")" : "");
}

/// "-" for null: not measured, or not there yet.
std::string number(const Json& value, int decimals) {
  return value.is_number() ? fixed(value.get<double>(), decimals) : "-";
}

std::string counted(std::uint64_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

std::string state(const Json& session) {
  if (const Json why = session.value("why_aside", Json()); why.is_string())
    return "set aside: " + printable(why.get<std::string>());
  if (session.value("archived", false)) return "archived";
  if (session.value("frozen", false)) return "frozen";
  const bool complete = session.at("complete").get<bool>();
  if (session.at("connected").get<bool>()) return complete ? "docked" : "live";
  return complete ? "complete" : "away";
}

/// "-" of a robot that is not connected.
std::string ago(const Json& seconds) { return seconds.is_number() ? fixed(seconds.get<double>(), 1) + " s ago" : "-"; }

/// "1.2 s ago, 83 %, left track slips": what a robot said last of itself; "-": nothing.
std::string live_text(const Json& live) {
  if (!live.is_object()) return "-";
  std::string text = ago(live.at("age_s"));
  if (live.at("battery").is_number()) text += ", " + fixed(100 * live.at("battery").get<double>(), 0) + " %";
  if (live.at("health").is_string()) text += ", " + printable(live.at("health").get<std::string>());
  return text;
}

std::string component_table(const Json& component, std::size_t width) {
  Table table{{{"  session"}, {"x m", true}, {"y m", true}, {"z m", true}, {"yaw deg", true}}, {}};
  const auto add = [&](const std::string& who, const Json& T) {
    const double yaw_deg = std::atan2(T.at(4).get<double>(), T.at(0).get<double>()) * 180 / M_PI;
    table.rows.push_back({"  " + who, number(T.at(3), 2), number(T.at(7), 2), number(T.at(11), 2), fixed(yaw_deg, 2)});
  };
  for (const Json& placed : component.at("sessions")) add(labelled(placed), placed.at("T_component_session"));
  for (const Json& placed : component.value("provisional", Json::array()))
    add(name(placed) + " (provisional, " + number(placed.at("awaited_m"), 0) + " m of path awaited)",
        placed.at("T_component_session"));
  return "\ncomponent " + component.at("id").dump() + ", in the frame of " + name(component.at("anchor")) + "\n" +
         table.text(width);
}

/// "published", and whether the operator had a word in it.
std::string state_of(const Json& alignment) {
  const auto decision = alignment.at("decision").get<std::string>(), now = alignment.at("state").get<std::string>();
  return decision == "none" || decision == now ? now : now + ", " + decision;
}

std::string alignment_table(const Json& alignments, std::size_t width) {
  Table table{{{"  id", true},
               {"a"},
               {"b"},
               {"state"},
               {"prob", true},
               {"overlap", true},
               {"violated", true},
               {"rmse m", true, 2},
               {"runner-up", true, 1}},
              {}};
  for (const Json& row : alignments) {
    const Json& evidence = row.at("evidence");
    const auto value = [&](const char* field, int decimals) { return number(evidence.value(field, Json()), decimals); };
    table.rows.push_back({row.at("id").dump(), name(row.at("a")), name(row.at("b")), state_of(row),
                          value("probability", 3), value("overlap_a", 2) + "/" + value("overlap_b", 2),
                          value("freespace_violation", 3), value("rmse_m", 2), value("runner_up", 2)});
  }
  return "\nalignments\n" + table.text(width);
}

/// Where odometry jumped, and what became of the rest: a line each.
std::string jumps_text(const Json& sessions) {
  std::string out;
  for (const Json& row : sessions)
    if (const Json why = row.value("why_cut", Json()); why.is_string())
      out += name(row) + ": " + printable(why.get<std::string>()) + "\n";
  return out;
}

/// Empty where all are of one family and version: then all can meet.
std::string families_text(const Json& sessions) {
  constexpr std::size_t named = 8;
  std::map<std::string, std::vector<std::string>> of_family;
  for (const Json& row : sessions) {
    const Json& family = row.at("family");
    const auto key = printable(family.at("name").get<std::string>()) + " version " + family.at("version").dump();
    of_family[key].push_back(name(row));
  }
  if (of_family.size() < 2) return {};
  std::string out = "not compared across these descriptor families\n";
  for (const auto& [family, names] : of_family) {
    out.append("  ").append(family).append(": ");
    for (std::size_t i = 0; i < std::min(named, names.size()); ++i) out.append(i == 0 ? "" : ", ").append(names[i]);
    if (names.size() > named) out.append(" and ").append(std::to_string(names.size() - named)).append(" more");
    out.append("\n");
  }
  return out;
}

}  // namespace

std::string alignments_view(const Json& alignments, std::size_t width) {
  const Json& rows = alignments.at("alignments");
  const auto left_out = alignments.value("left_out", 0);
  const std::string more =
      left_out == 0 ? "" : counted(left_out, "older pair") + " that came to nothing left out: --most N shows more\n";
  if (!rows.empty()) return alignment_table(rows, width).substr(1) + more;
  return more.empty() ? "no alignment yet: two sessions of one descriptor family are needed\n" : more;
}

std::string decision_view(const Json& decided) {
  const Json& row = decided.at("alignment");
  return "alignment " + row.at("id").dump() + ", " + name(row.at("a")) + " and " + name(row.at("b")) + ": " +
         state_of(row) + "; revision " + decided.at("revision").dump() + "\n";
}

std::string explanation_view(const Json& explanation) {
  const auto line = [](const Json& words) { return printable(words.get<std::string>()) + "\n"; };
  std::string out = line(explanation.at("outcome"));
  if (!explanation.at("decision").get<std::string>().empty()) out += line(explanation.at("decision"));
  if (!explanation.at("findings").empty()) out += "evidence, with what it adds to the log-odds\n";
  for (const Json& finding : explanation.at("findings")) {
    const auto suffices = finding.value("would_suffice", std::string());
    const double odds = finding.at("value").is_number() ? finding.at("value").get<double>() : 0;
    out += (odds <= -0.05 ? "  - " : "  + ") + fixed(std::abs(odds), 1) + "  " +
           printable(finding.at("text").get<std::string>()) + (suffices.empty() ? "" : " (" + suffices + ")") + "\n";
  }
  if (!explanation.at("gates").empty()) out += "gates\n";
  for (const Json& gate : explanation.at("gates"))
    out += (gate.at("passed").get<bool>() ? "  + " : "  - ") + printable(gate.at("gate").get<std::string>()) + ": " +
           line(gate.at("text"));
  if (!explanation.at("changes").empty()) out += "changes of the mine\n";
  for (const Json& c : explanation.at("changes")) {
    const Json &p = c.at("p"), &size = c.at("size_m");
    out += "    " + c.at("kind").get<std::string>() + " at x " + number(p.at(0), 1) + ", y " + number(p.at(1), 1) +
           ", z " + number(p.at(2), 1) + " m, " + number(size.at(0), 1) + " x " + number(size.at(1), 1) + " x " +
           number(size.at(2), 1) + " m, between " + date_of(c.at("older").at("stamp_s").get<double>()) + " and " +
           date_of(c.at("newer").at("stamp_s").get<double>()) + "\n";
  }
  if (!explanation.at("missing").empty()) out += "missing\n";
  for (const Json& what : explanation.at("missing")) out += "    " + line(what);
  return out;
}

std::string pending_view(const Json& pending) {
  std::string out;
  const auto add = [&](const char* field, const char* one) {
    const auto count = pending.at(field).get<std::uint64_t>();
    if (count > 0) out += (out.empty() ? "" : ", ") + counted(count, one);
  };
  add("attempts", "attempt");
  add("keyframes", "keyframe");
  add("awaited_submaps", "awaited submap");
  return out.empty() ? "nothing" : out;
}

std::string status_view(const Json& status) {
  const auto count = [&](const char* field) { return status.at(field).get<std::uint64_t>(); };
  std::string alignments;
  for (const auto& [state_name, number_of] : status.at("alignments").items())
    alignments += (alignments.empty() ? "" : ", ") + number_of.dump() + " " + state_name;
  std::string out = "headframe-server " + status.at("version").get<std::string>() + ", up for " +
                    number(status.at("uptime_s"), 0) + " s\n";
  out += "atlas       revision " + std::to_string(count("revision")) + ", " +
         counted(count("components"), "component") + " of " + counted(count("sessions"), "session") + "\n";
  out += "robots      " + std::to_string(count("connected")) + " connected\n";
  out += "received    " + counted(count("keyframes"), "keyframe") + ", " + counted(count("clouds"), "cloud") + "; " +
         bytes_text(static_cast<double>(count("bytes_received"))) + " since the server began\n";
  if (const Json hold = status.value("links", Json::object()).value("hold", Json()); hold.is_string())
    out += "ON HOLD     " + printable(hold.get<std::string>()) + "\n";
  out += "alignments  " + (alignments.empty() ? "none" : alignments) + "\n";
  return out + "pending     " + pending_view(status.at("pending")) + "\n";
}

std::string sessions_view(const Json& sessions, std::size_t width) {
  const Json& rows = sessions.at("sessions");
  if (rows.empty()) return "no session yet\n";
  Table table{{{"session"},
               {"state"},
               {"keyframes", true},
               {"clouds", true, 2},
               {"since start", true, 5},
               {"backlog", true, 1},
               {"rate", true, 3},
               {"heard", true, 4},
               {"distance", true, 6},
               {"component", true},
               {"merged in", true, 7},
               {"says of itself", false, 1},
               {"sensor", false, 8}},
              {}};
  const bool sites = std::any_of(rows.begin(), rows.end(),
                                 [](const Json& row) { return row.contains("site") && row["site"].is_string(); });
  if (sites) table.columns.push_back({"site"});
  for (const Json& row : rows) {
    const Json& ms = row.at("trigger_to_transform_ms");
    table.rows.push_back(
        {labelled(row), state(row), row.at("keyframes").dump(), row.at("clouds").dump(),
         bytes_text(row.at("bytes_received").get<double>()), row.value("backlog", Json(0)).dump(),
         bytes_text(row.value("bytes_per_s", 0.0)) + "/s", ago(row.value("link_age_s", Json())),
         number(row.at("distance_m"), 0) + " m", row.at("component").is_null() ? "-" : row.at("component").dump(),
         ms.is_number() ? fixed(ms.get<double>() / 1000, 1) + " s" : "-", live_text(row.value("live", Json())),
         printable(row.at("sensor").at("model").get<std::string>())});
    if (!sites) continue;
    const Json site = row.value("site", Json());
    table.rows.back().push_back(site.is_string() ? printable(site.get<std::string>()) : "-");
  }
  return table.text(width) + jumps_text(rows) + families_text(rows);
}

std::string atlas_view(const Json& atlas, std::size_t width) {
  const Json& components = atlas.at("components");
  std::size_t sessions = 0;
  for (const Json& component : components) sessions += component.at("sessions").size();
  std::string out = "revision " + atlas.at("revision").dump() + ": " + counted(components.size(), "component") +
                    " of " + counted(sessions, "session") + "\n";
  for (const Json& component : components) out += component_table(component, width);
  if (!atlas.at("alignments").empty()) out += alignment_table(atlas.at("alignments"), width);
  if (const auto rejected = atlas.value("rejected", std::size_t{0}); rejected > 0)
    out += "\n" + counted(rejected, "pair") + " came to nothing: headframe alignments lists them too\n";
  return out;
}

}  // namespace headframe
