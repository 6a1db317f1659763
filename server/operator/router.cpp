#include "server/operator/router.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "server/operator/api_json.hpp"
#include "server/operator/embedded_files.hpp"
#include "server/operator/explain_request.hpp"
#include "server/operator/map_export.hpp"
#include "server/operator/metrics.hpp"
#include "server/operator/request_target.hpp"
#include "server/operator/robot_json.hpp"
#include "server/operator/trajectory_export.hpp"

namespace headframe {
namespace {

using Query = std::map<std::string, std::string>;

struct Context {
  Station& station;
  PointTiles& tiles;
  const OperatorLimits& limits;
  double uptime_s;
  RobotAdmin* robots;
};

Ready json(std::string body, int status = 200) { return {status, "application/json", std::move(body), {}}; }

/// Also whether requests must show a token: a page asks for it before it sends a request in vain.
Result<Reply> healthz(const Query&, const Context& context) {
  return json(context.robots == nullptr ? "{\"status\":\"ok\",\"token\":false}\n"
                                        : "{\"status\":\"ok\",\"token\":true}\n");
}

Result<Reply> readyz(const Query&, const Context& context) {
  const std::string error = context.station.workload().disk_error;
  if (error.empty()) return json("{\"status\":\"ready\"}\n");
  return failure(ErrorCode::unavailable, "the disk refuses writes: " + error);
}

Result<Reply> metrics(const Query&, const Context& context) {
  const Station& station = context.station;
  return Ready{
      200,
      "text/plain; version=0.0.4; charset=utf-8",
      metrics_text(station.sessions(), station.atlas(), station.pending(), station.workload(), context.uptime_s),
      {}};
}

Ready file_reply(const EmbeddedFile& file) {
  return {200, std::string(file.content_type), std::string(file.bytes), {}, file.gzip};
}

Result<Reply> page(const Query&, const Context&) {
  if (const auto file = embedded_file("/")) return file_reply(*file);
  return Ready{200,
               "text/plain; charset=utf-8",
               "This headframe-server was built without its page; the API is under /api/v1/\n",
               {}};
}

Result<Reply> openapi(const Query&, const Context&) { return file_reply(*embedded_file("/api/v1/openapi.json")); }

Result<Reply> status(const Query&, const Context& context) {
  const Station& station = context.station;
  return json(
      status_json(station.sessions(), station.atlas(), station.pending(), station.link_health(), context.uptime_s));
}

Result<Reply> sessions(const Query&, const Context& context) {
  return json(sessions_json(context.station.sessions(), context.station.atlas().atlas));
}

Result<Reply> atlas(const Query& query, const Context& context) {
  const auto wait = query.find("wait");
  if (wait == query.end()) {
    const AtlasView view = context.station.atlas();  // before the names, which only grow
    return json(atlas_json(view, context.station.sessions(), nullptr));
  }
  const auto timeout_s = parse_number("wait", wait->second, 0, context.limits.wait_s);
  if (!timeout_s) return tl::unexpected(timeout_s.error());
  return Later{[&station = context.station, seconds = *timeout_s](auto answer) {
    station.when_idle(seconds, [&station, answer = std::move(answer)](const Pending& left) {
      const WaitOutcome outcome{left, !left.idle()};
      const AtlasView view = station.atlas();
      answer(json(atlas_json(view, station.sessions(), &outcome)));
    });
  }};
}

Result<Reply> alignments(const Query&, const Context& context) {
  return json(alignments_json(context.station.atlas()));
}

/// POST /api/v1/alignments/{id}/{decision}
Result<Reply> decide(const Query& query, const Context& context) {
  const std::string &id_text = query.at("id"), &name = query.at("decision");
  AlignmentId id = 0;
  const char* end = id_text.data() + id_text.size();
  if (std::from_chars(id_text.data(), end, id).ptr != end)
    return failure(ErrorCode::invalid_argument,
                   "\"" + id_text + "\" is no alignment; give its number, GET /api/v1/alignments lists them");
  const auto decision = decision_from(name);
  if (!decision)
    return failure(ErrorCode::not_found,
                   "\"" + name + "\" is no decision; there are confirm, refuse, retract and undo");
  return Later{[&station = context.station, id, decision = *decision](auto answer) {
    station.decide(id, decision, [&station, id, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(alignment_json(station.atlas(), id)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> merge(const Query&, const Context& context) {
  context.station.merge_all();
  return json("{\"queued\":true}\n", 202);
}

Result<std::string> required(const Query& query, const std::string& name) {
  const auto found = query.find(name);
  if (found == query.end() || found->second.empty())
    return failure(ErrorCode::invalid_argument, "parameter \"" + name + "\" is missing");
  return found->second;
}

Result<Reply> explain_pair(const Query& query, const Context& context) {
  const auto a = required(query, "a"), b = required(query, "b");
  if (!a) return tl::unexpected(a.error());
  if (!b) return tl::unexpected(b.error());
  return explain_request(context.station, *a, *b).map([](std::string body) -> Reply { return json(std::move(body)); });
}

Result<Reply> events(const Query&, const Context&) { return Upgrade{}; }

Result<CloudFormat> cloud_format(const Query& query) {
  const auto format = query.find("format");
  if (format == query.end() || format->second == "ply") return CloudFormat::ply;
  if (format->second == "pcd") return CloudFormat::pcd;
  if (format->second == "las") return CloudFormat::las;
  return failure(ErrorCode::invalid_argument,
                 "parameter \"format\" is \"" + format->second + "\"; give ply, pcd or las");
}

Result<double> voxel(const Query& query) {
  const auto text = query.find("voxel");
  if (text == query.end()) return ExportRequest().voxel_m;
  auto voxel_m = parse_number("voxel", text->second, 0, 100);
  if (voxel_m && *voxel_m > 0 && *voxel_m < 0.01)
    return failure(ErrorCode::invalid_argument, "parameter \"voxel\" is below 0.01; give more, or 0 for every point");
  return voxel_m;
}

Result<Reply> map(const Query& query, const Context& context) {
  const auto component = required(query, "component");
  if (!component) return tl::unexpected(component.error());
  ExportRequest request;
  const char* end = component->data() + component->size();
  if (std::from_chars(component->data(), end, request.component).ptr != end)
    return failure(ErrorCode::invalid_argument, "parameter \"component\" is \"" + *component +
                                                    "\"; give the id of a component, GET /api/v1/atlas lists them");
  const auto format = cloud_format(query);
  if (!format) return tl::unexpected(format.error());
  request.format = *format;
  const auto voxel_m = voxel(query);
  if (!voxel_m) return tl::unexpected(voxel_m.error());
  request.voxel_m = *voxel_m;
  if (const auto there = find_component(context.station.atlas().atlas, request.component); !there)
    return tl::unexpected(there.error());
  return Stream{"application/octet-stream", std::make_unique<MapExport>(context.station, request)};
}

Result<Reply> trajectory(const Query& query, const Context& context) {
  const auto robot = required(query, "robot");
  if (!robot) return tl::unexpected(robot.error());
  const auto session = required(query, "session");
  if (!session) return tl::unexpected(session.error());
  const auto format = query.find("format");
  const bool csv = format != query.end() && format->second == "csv";
  if (format != query.end() && !csv && format->second != "tum")
    return failure(ErrorCode::invalid_argument, "parameter \"format\" is \"" + format->second + "\"; give tum or csv");
  return Stream{csv ? "text/csv; charset=utf-8" : "text/plain; charset=utf-8",
                std::make_unique<TrajectoryExport>(context.station, SessionKey{*robot, *session},
                                                   csv ? TrajectoryFormat::csv : TrajectoryFormat::tum)};
}

/// The session whose id is in the path.
Result<SessionRow> session_in_path(const Query& query, const Context& context) {
  const std::string& text = query.at("id");
  SessionId id = 0;
  const char* end = text.data() + text.size();
  const bool number = std::from_chars(text.data(), end, id).ptr == end;
  for (SessionRow& row : context.station.sessions())
    if (number && row.id == id) return std::move(row);
  return failure(ErrorCode::not_found, "there is no session " + text + "; GET /api/v1/sessions lists their ids");
}

Result<std::size_t> whole_number(const Query& query, const char* name, double otherwise, double most) {
  const auto found = query.find(name);
  if (found == query.end()) return static_cast<std::size_t>(otherwise);
  return parse_number(name, found->second, 0, most).map([](double value) { return static_cast<std::size_t>(value); });
}

Result<Reply> points(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  const auto level = whole_number(query, "level", 2, static_cast<double>(level_cube_m.size() - 1));
  const auto first = whole_number(query, "from", 0, 1e9), most = whole_number(query, "most", 1e6, 1e7);
  for (const auto* number : {&level, &first, &most})
    if (!*number) return tl::unexpected(number->error());
  return Stream{"application/octet-stream",
                std::make_unique<PointStream>(context.tiles.tile(row->id, *level), *first, *most)};
}

Result<Reply> path(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  const auto first = whole_number(query, "from", 1, 1e15);
  if (!first) return tl::unexpected(first.error());
  return Stream{"application/json", std::make_unique<PathJson>(context.station, row->id, *first)};
}

Result<RobotAdmin*> robot_admin(const Context& context) {
  if (context.robots != nullptr) return context.robots;
  return failure(ErrorCode::refused, "this server runs with --insecure: robots come in without enrolling");
}

Result<Reply> robots(const Query&, const Context& context) {
  const auto admin = robot_admin(context);
  if (!admin) return tl::unexpected(admin.error());
  return json(robots_json((*admin)->robots(), (*admin)->fingerprint()));
}

Result<Reply> add_robot(const Query& query, const Context& context) {
  const auto admin = robot_admin(context);
  const auto robot = required(query, "robot");
  if (!admin || !robot) return tl::unexpected(admin ? robot.error() : admin.error());
  return Later{[admin = *admin, robot = *robot](const std::function<void(Ready)>& answer) {
    admin->add(robot, [robot, answer](const Result<std::string>& enrolment) {
      answer(enrolment ? json(enrolment_json(robot, *enrolment), 201) : error_reply(enrolment.error()));
    });
  }};
}

Result<Reply> revoke_robot(const Query& query, const Context& context) {
  const auto admin = robot_admin(context);
  const auto robot = required(query, "robot");
  if (!admin || !robot) return tl::unexpected(admin ? robot.error() : admin.error());
  return Later{[admin = *admin, robot = *robot](const std::function<void(Ready)>& answer) {
    admin->revoke(robot, [answer](const Result<void>& revoked) {
      answer(revoked ? json("{\"revoked\":true}\n") : error_reply(revoked.error()));
    });
  }};
}

struct Route {
  std::string_view method;
  std::string_view path;
  std::array<std::string_view, 3> parameters;
  Result<Reply> (*handle)(const Query&, const Context&);
};
constexpr std::array<Route, 20> routes{{{"GET", "/", {}, page},
                                        {"GET", "/api/v1/openapi.json", {}, openapi},
                                        {"GET", "/healthz", {}, healthz},
                                        {"GET", "/readyz", {}, readyz},
                                        {"GET", "/metrics", {}, metrics},
                                        {"GET", "/api/v1/status", {}, status},
                                        {"GET", "/api/v1/sessions", {}, sessions},
                                        {"GET", "/api/v1/atlas", {"wait"}, atlas},
                                        {"GET", "/api/v1/alignments", {}, alignments},
                                        {"POST", "/api/v1/alignments/{id}/{decision}", {}, decide},
                                        {"GET", "/api/v1/explain", {"a", "b"}, explain_pair},
                                        {"GET", "/api/v1/events", {}, events},
                                        {"GET", "/api/v1/sessions/{id}/points", {"level", "from", "most"}, points},
                                        {"GET", "/api/v1/sessions/{id}/trajectory", {"from"}, path},
                                        {"POST", "/api/v1/merge", {}, merge},
                                        {"GET", "/api/v1/export", {"component", "format", "voxel"}, map},
                                        {"GET", "/api/v1/trajectory", {"robot", "session", "format"}, trajectory},
                                        {"GET", "/api/v1/robots", {}, robots},
                                        {"POST", "/api/v1/robots/add", {"robot"}, add_robot},
                                        {"POST", "/api/v1/robots/revoke", {"robot"}, revoke_robot}}};

/// "{name}" in the pattern takes one piece of the path, however it is spelt.
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

Result<Reply> routed(std::string_view method, std::string_view text, const Context& context) {
  const auto target = parse_target(text);
  if (!target) return tl::unexpected(target.error());
  Query captured;
  const auto route = std::find_if(routes.begin(), routes.end(), [&](const Route& other) {
    captured.clear();
    return matches(other.path, target->path, captured);
  });
  if (const auto file = embedded_file(target->path); file && route == routes.end() && method == "GET")
    return file_reply(*file);
  if (route == routes.end())
    return failure(ErrorCode::not_found, "there is nothing at \"" + target->path + "\"; the API is under /api/v1/");
  if (route->method != method) {
    Ready refusal = error_reply(405, {ErrorCode::refused, target->path + " takes " + std::string(route->method)});
    refusal.allow = route->method;
    return refusal;
  }
  for (const auto& [name, value] : target->query)
    if (name.empty() || std::find(route->parameters.begin(), route->parameters.end(), name) == route->parameters.end())
      return failure(ErrorCode::invalid_argument, target->path + " has no parameter \"" + name + "\"");
  captured.insert(target->query.begin(), target->query.end());
  return route->handle(captured, context);
}

}  // namespace

std::vector<RouteName> route_names() {
  std::vector<RouteName> names;
  names.reserve(routes.size());
  for (const Route& route : routes) {
    names.push_back({route.method, route.path, {}});
    for (const std::string_view parameter : route.parameters)
      if (!parameter.empty()) names.back().parameters.push_back(parameter);
  }
  return names;
}

/// Probes, and the page, which asks for the token itself.
bool is_public(std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  return path == "/healthz" || path == "/readyz" || path == "/" || embedded_file(path);
}

Reply route(std::string_view method, std::string_view target, Station& station, PointTiles& tiles,
            const OperatorLimits& limits, double uptime_s, RobotAdmin* robots) {
  auto reply = routed(method, target, {station, tiles, limits, uptime_s, robots});
  if (!reply) return error_reply(reply.error());
  return std::move(*reply);
}

Ready error_reply(const Error& error) { return error_reply(http_status(error.code), error); }

Ready error_reply(int status, const Error& error) { return json(error_json(error), status); }

}  // namespace headframe
