#include "server/operator/log_lines.hpp"

#include <algorithm>
#include <set>

#include "server/atlas/explain.hpp"

namespace headframe {
namespace {

std::string full_name(const SessionKey& key) { return key.robot + "/" + key.session; }

std::string pair_of(const AlignmentRow& row) { return full_name(row.a) + " and " + full_name(row.b); }

std::string counted(std::size_t count, const char* one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

void add_sessions(const StationLook& before, const StationLook& after, std::vector<LogEntry>& lines) {
  std::map<SessionId, const SessionRow*> was;
  for (const SessionRow& row : before.sessions) was[row.id] = &row;
  for (const SessionRow& row : after.sessions) {
    const auto known = was.find(row.id);
    const SessionRow old = known == was.end() ? SessionRow{} : *known->second;
    const bool jumped = row.why_cut != old.why_cut && !row.why_cut.empty();
    if (jumped) lines.push_back({"jumped", full_name(row.key) + ": " + row.why_cut + ".", row.id});
    if (row.complete && !old.complete && !jumped)
      lines.push_back(
          {"finished", full_name(row.key) + " finished: " + counted(row.keyframes, "keyframe") + ".", row.id});
    if (row.let_go > old.let_go && known != was.end())
      lines.push_back({"let_go",
                       counted(row.let_go - old.let_go, "cloud") + " of " + full_name(row.key) +
                           " made room: later sessions keep that rock.",
                       row.id});
    if (row.connected != old.connected && !jumped)
      lines.push_back({row.connected ? "connected" : "left",
                       full_name(row.key) + (row.connected ? " connected." : " left."), row.id});
  }
}

std::optional<LogEntry> line_of(const Alignment* before, const AlignmentRow& row) {
  const Alignment& now = row.alignment;
  if (before && (before->state == now.state || before->ruling != now.ruling)) return std::nullopt;
  const auto line = [&](const char* kind, const std::string& text) { return LogEntry{kind, text, 0, now.id}; };
  if (now.state == AlignmentState::published) return line("merged", pair_of(row) + " are merged.");
  if (before && before->state == AlignmentState::published)
    return line("withdrawn",
                "The merge of " + pair_of(row) + " was withdrawn: " + why_withdrawn(now) + ". The robots were told.");
  switch (now.state) {
    case AlignmentState::verified:
      return line("held_back", pair_of(row) + " fit each other but are held back: other sessions contradict it.");
    case AlignmentState::provisional:
      return line("provisional", pair_of(row) + " fit each other; a robot that still drives may yet tell otherwise.");
    case AlignmentState::candidate: return line("unsure", pair_of(row) + " may overlap; not sure enough to merge.");
    case AlignmentState::rejected:
      if (before) return line("no_match", pair_of(row) + ": no overlap any more.");
      break;
    case AlignmentState::retracted:
    case AlignmentState::published: break;
  }
  return std::nullopt;
}

std::string session_named(const std::map<std::string, std::string>& parameters, const char* parameter,
                          const Station& station, SessionId& id) {
  const auto text = parameters.find(parameter);
  if (text == parameters.end()) return "a session";
  for (const SessionRow& row : station.sessions())
    if (std::to_string(row.id) == text->second) {
      id = row.id;
      return full_name(row.key);
    }
  return "session " + text->second;
}

LogEntry decision_line(const std::map<std::string, std::string>& parameters, const Station& station,
                       const std::string& name) {
  LogEntry entry{"operator", "", 0, 0};
  std::string pair = "a pair";
  for (const AlignmentRow& row : station.atlas().alignments)
    if (std::to_string(row.alignment.id) == parameters.at("id")) {
      entry.alignment = row.alignment.id;
      pair = pair_of(row);
    }
  const std::string& decision = parameters.at("decision");
  entry.text = name + (decision == "confirm"  ? " confirmed " + pair + "."
                       : decision == "refuse" ? " refused " + pair + "."
                       : decision == "undo"   ? " undid the decision on " + pair + "."
                                              : " took " + pair + " apart.");
  return entry;
}

}  // namespace

std::vector<LogEntry> log_lines(const StationLook& before, const StationLook& after) {
  std::vector<LogEntry> lines;
  add_sessions(before, after, lines);
  std::map<AlignmentId, const Alignment*> was;
  std::set<SessionId> left_out;
  std::map<SessionId, std::string> sites;
  for (const SessionRow& row : after.sessions) {
    if (row.archived) left_out.insert(row.id);
    sites[row.id] = row.site;
  }
  for (const AlignmentRow& row : before.view.alignments) was[row.alignment.id] = &row.alignment;
  for (const AlignmentRow& row : after.view.alignments) {
    const Alignment& now = row.alignment;
    const bool across_sites = now.ruling == Ruling::none && sites[now.a] != sites[now.b];
    if (left_out.contains(now.a) || left_out.contains(now.b) || across_sites) continue;  // not due to evidence
    const auto known = was.find(row.alignment.id);
    if (auto line = line_of(known == was.end() ? nullptr : known->second, row)) lines.push_back(std::move(*line));
  }
  const Atlas& atlas = after.view.atlas;
  if (before.view.atlas.revision != atlas.revision)
    lines.push_back({"revision", "Revision " + std::to_string(atlas.revision) + ": " +
                                     counted(atlas.components.size(), "map") + "."});
  return lines;
}

std::optional<LogEntry> operator_line(std::string_view method, std::string_view path,
                                      const std::map<std::string, std::string>& parameters, const Station& station,
                                      const std::string& who) {
  if (method == "GET") return std::nullopt;
  const std::string actor = who.empty() ? "An operator" : who;
  LogEntry entry{"operator", "", 0, 0};
  entry.by = who;
  if (path.ends_with("{decision}")) {
    entry = decision_line(parameters, station, actor);
    entry.by = who;
    return entry;
  }
  const auto given = [&](const char* name) {
    const auto found = parameters.find(name);
    return found == parameters.end() ? std::string() : found->second;
  };
  const auto of = [&](const char* parameter, const std::string& before, const std::string& after = {}) {
    entry.text = actor + " " + before + session_named(parameters, parameter, station, entry.session) + after + ".";
  };
  if (path.ends_with("/merge")) entry.text = actor + " asked for merges.";
  if (path.ends_with("/rename"))
    of("id", "called ", given("name").empty() ? " by its robot again" : " \"" + given("name") + "\"");
  if (path.ends_with("/anchor")) of("id", "anchored the map to ");
  if (path.ends_with("/request-clouds")) of("id", "asked for the clouds of ");
  if (path.ends_with("/quarantine")) of("id", "set ", " aside");
  if (path.ends_with("/release")) of("id", "released ");
  if (path.ends_with("/archive")) of("id", "archived ");
  if (path.ends_with("/restore")) of("id", "restored ");
  if (path.ends_with("/freeze")) of("id", "froze ");
  if (path.ends_with("/thaw")) of("id", "thawed ");
  const auto site = [&] { return given("site").empty() ? std::string("no site") : "the site " + given("site"); };
  if (path.ends_with("/sessions/{id}/site")) of("id", "said that ", " is of " + site());
  if (path.ends_with("/sites"))
    entry.text = actor + " said that what " + given("robot") + " drives from now on is of " + site() + ".";
  if (path.ends_with("/sessions/{id}/note")) of("id", "wrote a note on ");
  if (method == "DELETE" && path.ends_with("/sessions/{id}")) of("id", "deleted ");
  if (path.ends_with("/place")) entry.text = actor + " laid " + given("b") + " on " + given("a") + " by hand.";
  if (path.ends_with("/store/let-go")) entry.text = actor + " let covered clouds go.";
  if (path.ends_with("/survey")) of("session", method == "DELETE" ? "took away the survey of " : "surveyed ");
  if (path.ends_with("/robots/add")) entry.text = actor + " invited " + given("robot") + ".";
  if (path.ends_with("/robots/rate"))
    entry.text = actor + " lets " + given("robot") + " send " +
                 (given("kib_s") == "0" ? "what it can" : given("kib_s") + " KiB/s at most") + ".";
  if (path.ends_with("/operators/add"))
    entry.text = actor + " lets " + given("name") + " " + (given("role").empty() ? "operate" : given("role")) + ".";
  if (path.ends_with("/sign-in")) entry.text = actor + " signed in.";
  if (path.ends_with("/sign-out")) entry.text = actor + " signed out.";
  if (path.ends_with("/operators/revoke")) entry.text = actor + " revoked the token of " + given("name") + ".";
  if (path.ends_with("/robots/revoke")) entry.text = actor + " cut " + given("robot") + " off.";
  if (entry.text.empty()) return std::nullopt;
  return entry;
}

}  // namespace headframe
