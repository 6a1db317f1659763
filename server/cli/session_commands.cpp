// What the operator does with one session.
#include <algorithm>
#include <charconv>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

std::string target_of(const Json& session, const char* action) {
  return "/api/v1/sessions/" + session.at("id").dump() + "/" + action;
}

std::string full_name(const Json& session) {
  return printable(session.at("robot").get<std::string>() + "/" + session.at("session").get<std::string>());
}

std::string names_of(const Json& sessions) {
  std::string all;
  for (const Json& session : sessions) all += (all.empty() ? "" : ", ") + full_name(session);
  return all;
}

/// One line for each thing.
std::string what_hangs_on(const std::string& name, const Json& found) {
  std::string out =
      name + ": " + found.at("keyframes").dump() + " keyframes, " + found.at("clouds").dump() + " clouds are deleted\n";
  if (!found.at("merged_with").empty()) out += "  merged with " + names_of(found.at("merged_with")) + "\n";
  if (found.at("anchor").get<bool>()) out += "  its map is anchored to it, and gets the frame of another session\n";
  if (found.at("parts").size() > 1) {
    out += "  its map comes apart:";
    for (const Json& part : found.at("parts")) out += " [" + names_of(part) + "]";
    out += "\n";
  }
  if (found.at("surveyed").get<bool>()) out += "  its survey goes with it\n";
  if (found.at("frozen").get<bool>()) out += "  it is frozen: others are aligned to it as reference\n";
  if (found.at("connected").get<bool>()) out += "  its robot is connected, and has to begin another session\n";
  return out;
}

/// Between semicolons or tabs, where the comma is the decimal sign; else between commas or blanks.
std::vector<std::string> cells_of(std::string line) {
  const bool strict = line.find_first_of(";\t") != std::string::npos;
  if (strict) {
    std::replace(line.begin(), line.end(), ',', '.');
    std::replace(line.begin(), line.end(), '\t', ';');
  }
  std::vector<std::string> cells;
  const char* between = strict ? ";" : ", ";
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(between, at), line.size());
    std::string cell = line.substr(at, end - at);
    cell.erase(0, cell.find_first_not_of(' '));
    cell.erase(cell.find_last_not_of(' ') + 1);
    if (strict || !cell.empty()) cells.push_back(std::move(cell));
    at = end + 1;
  }
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

std::optional<double> number_of(const std::string& cell) {
  double value = 0;
  const char* begin = cell.data() + (cell.rfind('+', 0) == 0 ? 1 : 0);
  const auto [end, fault] = std::from_chars(begin, cell.data() + cell.size(), value);
  return fault == std::errc() && end == cell.data() + cell.size() && !cell.empty() ? std::optional(value)
                                                                                   : std::nullopt;
}

/// Seven cells a line: a name, then x, y, z in the session and east, north, height in the grid. Lines that begin with #
/// are comments, and so is a first line of titles.
Result<Json> points_from_csv(std::istream& file, const std::string& path) {
  constexpr std::size_t figures = 6;
  Json points = Json::array();
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::vector<std::string> cells = cells_of(line);
    if (cells.empty() || cells[0].rfind('#', 0) == 0) continue;
    std::vector<double> values;
    for (std::size_t i = 1; i < cells.size(); ++i)
      if (const auto value = number_of(cells[i])) values.push_back(*value);
    if (points.empty() && values.empty() && cells.size() > 1) continue;  // titles
    if (values.size() != figures || cells.size() != figures + 1)
      return failure(ErrorCode::bad_input, path + ", line " + std::to_string(number) +
                                               ": give name,x_session,y_session,z_session,east,north,height");
    points.push_back({{"name", cells[0]},
                      {"p_session", {values[0], values[1], values[2]}},
                      {"p_grid", {values[3], values[4], values[5]}}});
  }
  return Json{{"points", std::move(points)}};
}

/// What to post: the points of a .csv, or the JSON that the file holds.
Result<std::string> survey_body(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(ErrorCode::not_found, "there is no file " + path + ", or it can not be read");
  if (path.size() > 4 && path.substr(path.size() - 4) == ".csv")
    return points_from_csv(file, path).map([](const Json& points) { return points.dump(); });
  return std::string(std::istreambuf_iterator<char>(file), {});
}

}  // namespace

Result<int> Commands::rename(const std::string& session, const std::string& label) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(posted(target_of(row, "rename?name=") + percent_encoded(label), 200), [&](const Json&) {
      return full_name(row) + (label.empty() ? " has no label now\n" : ": " + printable(label) + "\n");
    });
  });
}

Result<int> Commands::anchor(const std::string& session) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(posted(target_of(row, "anchor"), 200), [&](const Json& json) {
      return "component " + json.at("component").dump() + " is in the frame of " + full_name(row) + "; revision " +
             json.at("revision").dump() + "\n";
    });
  });
}

Result<int> Commands::request_clouds(const std::string& session) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(posted(target_of(row, "request-clouds"), 202), [&](const Json& json) {
      return full_name(row) + ": " + json.at("requested").dump() +
             " clouds asked for; sessions shows how many have come\n";
    });
  });
}

Result<int> Commands::quarantine(const std::string& session, const std::string& reason) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(posted(target_of(row, "quarantine?reason=") + percent_encoded(reason), 200),
                   [&](const Json&) { return full_name(row) + " is set aside; session release takes it back\n"; });
  });
}

Result<int> Commands::release(const std::string& session) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(posted(target_of(row, "release"), 200),
                   [&](const Json&) { return full_name(row) + " is merged again\n"; });
  });
}

Result<int> Commands::tend(const std::string& session, const char* action, const char* done) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(posted(target_of(row, action), 200), [&](const Json&) { return full_name(row) + done + "\n"; });
  });
}

Result<int> Commands::note(const std::string& session, const std::optional<std::string>& text) {
  return session_named(session).and_then([&](const Json& row) -> Result<int> {
    if (!text) {
      const Json note = row.value("note", Json());
      std::cout << (note.is_string() ? printable(note.get<std::string>()) + "\n" : full_name(row) + " has no note\n");
      return exit_ok;
    }
    return printed(posted(target_of(row, "note"), 200, *text),
                   [&](const Json&) { return full_name(row) + (text->empty() ? " has no note now\n" : ": noted\n"); });
  });
}

Result<int> Commands::remove_session(const std::string& session, bool all_the_same) {
  return session_named(session).and_then([&](const Json& row) -> Result<int> {
    if (!all_the_same) {
      const auto body = fetched(target_of(row, "dependents"));
      if (!body) return tl::unexpected(body.error());
      std::cerr << what_hangs_on(full_name(row), Json::parse(*body));
      return failure(ErrorCode::refused,
                     "nothing was deleted; what is deleted is gone for good: --yes does it, session "
                     "archive keeps it out of everything instead");
    }
    return printed(removed("/api/v1/sessions/" + row.at("id").dump()),
                   [&](const Json&) { return full_name(row) + " is deleted\n"; });
  });
}

Result<int> Commands::list_surveys() { return printed(fetched("/api/v1/survey"), across_terminal(surveys_view)); }

Result<int> Commands::set_survey(const std::string& session, const std::string& file, bool accept) {
  const auto content = survey_body(file);
  if (!content) return tl::unexpected(content.error());
  const auto row = session_named(session);
  if (!row) return tl::unexpected(row.error());
  const std::string target = "/api/v1/survey?session=" + row->at("id").dump() + (accept ? "&accept=true" : "");
  const auto body = posted(target, 200, *content);
  if (!body && body.error().message.find("to stand all the same") != std::string::npos)
    return failure(body.error().code, body.error().message + ": --accept");
  return printed(body, across_terminal(survey_view));
}

Result<int> Commands::drop_survey(const std::string& session) {
  return session_named(session).and_then([&](const Json& row) {
    return printed(removed("/api/v1/survey?session=" + row.at("id").dump()),
                   [&](const Json&) { return full_name(row) + " has no survey now\n"; });
  });
}

Result<int> Commands::overlay(const std::string& alignment, int most) {
  const std::string target =
      "/api/v1/alignments/" + percent_encoded(alignment) + "/overlay?most=" + std::to_string(most);
  return printed(fetched(target), overlay_view);
}

}  // namespace headframe
