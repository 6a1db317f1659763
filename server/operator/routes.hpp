#pragma once
// The handlers of the routes, by topic; router.cpp selects one. Included only by the .cpp files of this room.

#include <map>

#include "server/operator/embedded_files.hpp"
#include "server/operator/router.hpp"

namespace headframe::routes {

/// Query parameters and path parameters, by name.
using Query = std::map<std::string, std::string>;

struct Context {
  Station& station;
  PointTiles& tiles;
  const OperatorLimits& limits;
  double uptime_s;
  RobotAdmin* robots;
  std::string_view body;  // the request's body
  OperatorIdentity who;
  const OperatorRecords& records;  // valid only while the request is handled: a Later copies what it needs
};

// routes.cpp: helpers that several handlers need.
Ready json(std::string body, int status = 200);
Ready file_reply(const EmbeddedFile& file);
/// invalid_argument: it is missing or empty.
Result<std::string> required(const Query& query, const std::string& name);
/// An integer, such as an id; nullopt: the text is not one.
std::optional<std::int64_t> whole(const std::string& text);
Result<std::size_t> whole_number(const Query& query, const char* name, double otherwise, double most);
/// The session with this id. not_found: there is none.
Result<SessionRow> session_with(const std::string& id, const Context& context);
/// The session whose id is in the path.
Result<SessionRow> session_in_path(const Query& query, const Context& context);
/// The alignment id in the path or query. Whether the alignment exists is not checked.
Result<AlignmentId> alignment_named(const Query& query);

// service_routes.cpp
Result<Reply> page(const Query&, const Context&);
Result<Reply> openapi(const Query&, const Context&);
Result<Reply> healthz(const Query&, const Context&);
Result<Reply> readyz(const Query&, const Context&);
Result<Reply> metrics(const Query&, const Context&);
Result<Reply> events(const Query&, const Context&);
Result<Reply> log(const Query&, const Context&);
Result<Reply> backup(const Query&, const Context&);
Result<Reply> servers(const Query&, const Context&);

// view_routes.cpp
Result<Reply> status(const Query&, const Context&);
Result<Reply> sessions(const Query&, const Context&);
Result<Reply> atlas(const Query&, const Context&);
Result<Reply> alignments(const Query&, const Context&);
Result<Reply> changes(const Query&, const Context&);
Result<Reply> explain_pair(const Query&, const Context&);
Result<Reply> overview(const Query&, const Context&);
Result<Reply> points(const Query&, const Context&);
Result<Reply> path(const Query&, const Context&);
Result<Reply> overlay(const Query&, const Context&);

// action_routes.cpp
Result<Reply> decide(const Query&, const Context&);
Result<Reply> merge(const Query&, const Context&);
Result<Reply> rename(const Query&, const Context&);
Result<Reply> anchor(const Query&, const Context&);
Result<Reply> request_clouds(const Query&, const Context&);
Result<Reply> quarantine(const Query&, const Context&);
Result<Reply> release(const Query&, const Context&);
Result<Reply> remove_session(const Query&, const Context&);

// tending_routes.cpp
Result<Reply> archive(const Query&, const Context&);
Result<Reply> restore_session(const Query&, const Context&);
Result<Reply> freeze(const Query&, const Context&);
Result<Reply> set_site(const Query&, const Context&);
Result<Reply> sites(const Query&, const Context&);
Result<Reply> set_robot_site(const Query&, const Context&);
Result<Reply> thaw(const Query&, const Context&);
Result<Reply> note_session(const Query&, const Context&);
Result<Reply> dependents(const Query&, const Context&);

// place_routes.cpp
Result<Reply> place(const Query&, const Context&);

// store_routes.cpp
Result<Reply> store(const Query&, const Context&);
Result<Reply> let_go(const Query&, const Context&);

// survey_routes.cpp
Result<Reply> surveys(const Query&, const Context&);
Result<Reply> set_survey(const Query&, const Context&);
Result<Reply> drop_survey(const Query&, const Context&);

// export_routes.cpp
Result<Reply> map(const Query&, const Context&);
Result<Reply> plan(const Query&, const Context&);
Result<Reply> trajectory(const Query&, const Context&);

// note_routes.cpp
Result<Reply> notes(const Query&, const Context&);
Result<Reply> add_note(const Query&, const Context&);
Result<Reply> remove_note(const Query&, const Context&);

// people_routes.cpp
Result<Reply> me(const Query&, const Context&);
Result<Reply> operators(const Query&, const Context&);
Result<Reply> add_operator(const Query&, const Context&);
Result<Reply> revoke_operator(const Query&, const Context&);
Result<Reply> sign_in(const Query&, const Context&);
Result<Reply> sign_out(const Query&, const Context&);

// robot_routes.cpp
Result<Reply> robots(const Query&, const Context&);
Result<Reply> add_robot(const Query&, const Context&);
Result<Reply> rate_robot(const Query&, const Context&);
Result<Reply> revoke_robot(const Query&, const Context&);

}  // namespace headframe::routes
