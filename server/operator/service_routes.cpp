#include <nlohmann/json.hpp>

#include "server/operator/backup_body.hpp"
#include "server/operator/metrics.hpp"
#include "server/operator/routes.hpp"

namespace headframe::routes {

/// Also whether requests must show a token: a page asks for it before it sends a request in vain.
Result<Reply> healthz(const Query&, const Context& context) {
  return json(context.robots == nullptr ? "{\"status\":\"ok\",\"token\":false}\n"
                                        : "{\"status\":\"ok\",\"token\":true}\n");
}

Result<Reply> readyz(const Query&, const Context& context) {
  const Workload work = context.station.workload();
  if (!work.disk_error.empty()) return failure(ErrorCode::unavailable, "the disk refuses writes: " + work.disk_error);
  if (!work.merge_stuck.empty()) return failure(ErrorCode::unavailable, work.merge_stuck);
  return json("{\"status\":\"ready\"}\n");
}

Result<Reply> metrics(const Query&, const Context& context) {
  const Station& station = context.station;
  return Ready{200,
               "text/plain; version=0.0.4; charset=utf-8",
               metrics_text(station.sessions(), station.atlas(), station.pending(), station.workload(),
                            station.link_health(), station.surveys(), context.uptime_s),
               {}};
}

Result<Reply> backup(const Query&, const Context& context) {
  return Stream{"application/vnd.sqlite3", std::make_unique<BackupBody>(context.station)};
}

Result<Reply> servers(const Query&, const Context& context) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ServerRecord& server : context.station.servers()) {
    nlohmann::json searches = nlohmann::json::array();
    for (const std::int64_t session : {server.searches_a, server.searches_b})
      if (session != 0) searches.push_back(session);
    rows.push_back({{"name", server.name},
                    {"robots", server.robots},
                    {"http", server.http},
                    {"role", server.is_active ? "active" : "standby"},
                    {"self", server.is_self},
                    {"since_s", server.since_s},
                    {"heard_ago_s", server.heard_ago_s},
                    {"relayed", server.relayed.value_or(0)},
                    {"searched", server.searched},
                    {"searches", searches}});
  }
  return json(nlohmann::json{{"servers", std::move(rows)}}.dump() + "\n");
}

Result<Reply> page(const Query&, const Context&) {
  if (const auto file = embedded_file("/")) return file_reply(*file);
  return Ready{200,
               "text/plain; charset=utf-8",
               "This headframe-server was built without its page; the API is under /api/v1/\n",
               {}};
}

Result<Reply> openapi(const Query&, const Context&) { return file_reply(*embedded_file("/api/v1/openapi.json")); }

Result<Reply> log(const Query& query, const Context& context) {
  const auto most = whole_number(query, "most", 200, 1000);
  if (!most) return tl::unexpected(most.error());
  return json(log_json(context.records.log ? context.records.log->latest(*most) : std::vector<LogEntry>()));
}

Result<Reply> events(const Query&, const Context&) { return Upgrade{}; }

}  // namespace headframe::routes
