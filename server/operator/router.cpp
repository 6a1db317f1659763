#include "server/operator/router.hpp"

#include <algorithm>
#include <array>

#include "server/operator/api_json.hpp"
#include "server/operator/log_lines.hpp"
#include "server/operator/request_target.hpp"
#include "server/operator/routes.hpp"

namespace headframe {
namespace {

using namespace routes;

struct Route {
  std::string_view method;
  std::string_view path;
  std::array<std::string_view, 6> parameters;
  Result<Reply> (*handle)(const Query&, const Context&);
};
constexpr std::array all_routes =
    std::to_array<Route>({{"GET", "/", {}, page},
                          {"GET", "/api/v1/openapi.json", {}, openapi},
                          {"GET", "/healthz", {}, healthz},
                          {"GET", "/readyz", {}, readyz},
                          {"GET", "/metrics", {}, metrics},
                          {"GET", "/api/v1/status", {}, status},
                          {"GET", "/api/v1/sessions", {}, sessions},
                          {"GET", "/api/v1/atlas", {"wait"}, atlas},
                          {"GET", "/api/v1/alignments", {"state", "id", "most"}, alignments},
                          {"GET", "/api/v1/changes", {"since"}, changes},
                          {"POST", "/api/v1/alignments/{id}/{decision}", {}, decide},
                          {"GET", "/api/v1/explain", {"a", "b"}, explain_pair},
                          {"POST", "/api/v1/place", {"a", "b"}, place},
                          {"GET", "/api/v1/events", {}, events},
                          {"GET", "/api/v1/log", {"most"}, log},
                          {"GET", "/api/v1/backup", {}, backup},
                          {"GET", "/api/v1/servers", {}, servers},
                          {"GET", "/api/v1/overview", {"level", "most", "tolerance"}, overview},
                          {"GET", "/api/v1/sessions/{id}/points", {"level", "from", "most"}, points},
                          {"GET", "/api/v1/sessions/{id}/trajectory", {"from", "tolerance"}, path},
                          {"GET", "/api/v1/alignments/{id}/overlay", {"most"}, overlay},
                          {"POST", "/api/v1/sessions/{id}/rename", {"name"}, rename},
                          {"POST", "/api/v1/sessions/{id}/anchor", {}, anchor},
                          {"POST", "/api/v1/sessions/{id}/request-clouds", {}, request_clouds},
                          {"POST", "/api/v1/sessions/{id}/quarantine", {"reason"}, quarantine},
                          {"POST", "/api/v1/sessions/{id}/release", {}, release},
                          {"POST", "/api/v1/sessions/{id}/archive", {}, archive},
                          {"POST", "/api/v1/sessions/{id}/restore", {}, restore_session},
                          {"POST", "/api/v1/sessions/{id}/freeze", {}, freeze},
                          {"POST", "/api/v1/sessions/{id}/thaw", {}, thaw},
                          {"POST", "/api/v1/sessions/{id}/note", {"text"}, note_session},
                          {"POST", "/api/v1/sessions/{id}/site", {"site"}, set_site},
                          {"GET", "/api/v1/sites", {}, sites},
                          {"POST", "/api/v1/sites", {"robot", "site"}, set_robot_site},
                          {"GET", "/api/v1/sessions/{id}/dependents", {}, dependents},
                          {"DELETE", "/api/v1/sessions/{id}", {}, remove_session},
                          {"GET", "/api/v1/store", {}, store},
                          {"POST", "/api/v1/store/let-go", {"bytes"}, let_go},
                          {"GET", "/api/v1/survey", {}, surveys},
                          {"POST", "/api/v1/survey", {"session", "accept"}, set_survey},
                          {"DELETE", "/api/v1/survey", {"session"}, drop_survey},
                          {"GET", "/api/v1/notes", {}, notes},
                          {"POST", "/api/v1/notes", {}, add_note},
                          {"DELETE", "/api/v1/notes/{id}", {}, remove_note},
                          {"GET", "/api/v1/me", {}, me},
                          {"POST", "/api/v1/sign-in", {}, sign_in},
                          {"POST", "/api/v1/sign-out", {}, sign_out},
                          {"GET", "/api/v1/operators", {}, operators},
                          {"POST", "/api/v1/operators/add", {"name", "role", "days"}, add_operator},
                          {"POST", "/api/v1/operators/revoke", {"name"}, revoke_operator},
                          {"POST", "/api/v1/merge", {}, merge},
                          {"GET", "/api/v1/export", {"component", "format", "voxel", "frame"}, map},
                          {"GET", "/api/v1/plan", {"component", "frame", "format", "scale", "low", "high"}, plan},
                          {"GET", "/api/v1/trajectory", {"robot", "session", "format", "frame"}, trajectory},
                          {"GET", "/api/v1/robots", {}, robots},
                          {"POST", "/api/v1/robots/add", {"robot"}, add_robot},
                          {"POST", "/api/v1/robots/rate", {"robot", "kib_s"}, rate_robot},
                          {"POST", "/api/v1/robots/revoke", {"robot"}, revoke_robot}});

/// "{name}" in the pattern matches any one segment of the path that is not empty.
bool matches(std::string_view pattern, std::string_view path, Query& captured) {
  while (!pattern.empty() && !path.empty()) {
    const std::string_view want = pattern.substr(0, pattern.find('/', 1)), have = path.substr(0, path.find('/', 1));
    const bool any = want.size() > 3 && want[1] == '{';
    if (any ? have.size() < 2 : want != have) return false;
    if (any) captured.emplace(want.substr(2, want.size() - 3), have.substr(1));
    pattern.remove_prefix(want.size());
    path.remove_prefix(have.size());
  }
  return pattern.empty() && path.empty();
}

int http_status(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
    case ErrorCode::bad_input: return 400;
    case ErrorCode::not_found: return 404;
    case ErrorCode::unavailable: return 503;
    case ErrorCode::refused: return 403;
    case ErrorCode::incompatible:
    case ErrorCode::internal: break;
  }
  return 500;
}

Ready not_allowed(const std::string& path, const std::vector<const Route*>& there) {
  std::string methods;
  for (const Route* route : there) methods.append(methods.empty() ? "" : ", ").append(route->method);
  Ready refusal = error_reply(405, {ErrorCode::refused, path + " takes " + methods});
  refusal.allow = methods;
  return refusal;
}

/// Calls the route's handler, and logs the operator's change if it succeeds.
Result<Reply> noted(const Route& route, const Query& query, const Context& context) {
  const auto& log = context.records.log;
  auto line = log ? operator_line(route.method, route.path, query, context.station, context.who.name) : std::nullopt;
  auto reply = route.handle(query, context);
  if (!line || !reply) return reply;
  const auto note = [log, line = std::move(*line)](const Ready& ready) {
    if (ready.status < 300) log->add(line);
  };
  if (const auto* ready = std::get_if<Ready>(&*reply)) note(*ready);
  if (auto* later = std::get_if<Later>(&*reply))
    later->start = [start = std::move(later->start), note](std::function<void(Ready)> answer) {
      start([note, answer = std::move(answer)](Ready ready) {
        note(ready);
        answer(std::move(ready));
      });
    };
  return reply;
}

Result<Reply> routed(const Request& request, const Context& context) {
  const auto target = parse_target(request.target);
  if (!target) return tl::unexpected(target.error());
  std::vector<const Route*> there;
  Query captured;
  for (const Route& route : all_routes) {
    Query pieces;
    if (!matches(route.path, target->path, pieces)) continue;
    there.push_back(&route);
    captured = std::move(pieces);
  }
  if (const auto file = embedded_file(target->path); file && there.empty() && request.method == "GET")
    return file_reply(*file);
  if (there.empty())
    return failure(ErrorCode::not_found, "there is nothing at \"" + target->path + "\"; the API is under /api/v1/");
  const auto found =
      std::find_if(there.begin(), there.end(), [&](const Route* route) { return route->method == request.method; });
  if (found == there.end()) return not_allowed(target->path, there);
  const Route& route = **found;
  if (const Role least = role_for(route.method, route.path); context.who.role < least)
    return failure(ErrorCode::refused, context.who.name + " may " + std::string(to_string(context.who.role)) +
                                           "; this is for those who may " + std::string(to_string(least)));
  for (const auto& [name, value] : target->query)
    if (name.empty() || std::find(route.parameters.begin(), route.parameters.end(), name) == route.parameters.end())
      return failure(ErrorCode::invalid_argument, target->path + " has no parameter \"" + name + "\"");
  captured.insert(target->query.begin(), target->query.end());
  return noted(route, captured, context);
}

}  // namespace

/// A higher role includes the lower ones. Only administer allows routes that control access, reveal the server's
/// secrets, or delete sessions or clouds for good.
Role role_for(std::string_view method, std::string_view path) {
  const bool of_people = path.starts_with("/api/v1/robots/") || path.starts_with("/api/v1/operators");
  if (of_people || path == "/api/v1/backup" || path == "/api/v1/store/let-go" ||
      (method == "DELETE" && path == "/api/v1/sessions/{id}"))
    return Role::administer;
  const bool of_page = path == "/api/v1/sign-in" || path == "/api/v1/sign-out";
  return method == "GET" || of_page ? Role::view : Role::operate;
}

std::vector<RouteName> route_names() {
  std::vector<RouteName> names;
  names.reserve(all_routes.size());
  for (const Route& route : all_routes) {
    names.push_back({route.method, route.path, {}});
    for (const std::string_view parameter : route.parameters)
      if (!parameter.empty()) names.back().parameters.push_back(parameter);
  }
  return names;
}

/// Health probes, and the page, which asks for the token itself.
bool is_public(std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  return path == "/healthz" || path == "/readyz" || path == "/" || embedded_file(path);
}

Reply route(const Request& request, Station& station, PointTiles& tiles, const OperatorLimits& limits, double uptime_s,
            RobotAdmin* robots, const OperatorRecords& records) {
  auto reply = routed(request, {station, tiles, limits, uptime_s, robots, request.body, request.who, records});
  if (!reply) return error_reply(reply.error());
  return std::move(*reply);
}

Ready error_reply(const Error& error) { return error_reply(http_status(error.code), error); }

Ready error_reply(int status, const Error& error) { return json(error_json(error), status); }

}  // namespace headframe
