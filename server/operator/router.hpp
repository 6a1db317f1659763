#pragma once
// From a request to what has to be done for it. No I/O: http_session does it.

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "server/operator/body_source.hpp"
#include "server/operator/event_log.hpp"
#include "server/operator/note_book.hpp"
#include "server/operator/operator_limits.hpp"
#include "server/operator/point_tiles.hpp"
#include "server/security/operator_registry.hpp"
#include "server/station/robot_admin.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// A response that is known at once.
struct Ready {
  int status = 200;
  std::string content_type;
  std::string body;
  std::string allow;          // of a 405
  bool gzip = false;          // how the body is encoded
  bool bearer = false;        // of a 401: a token is wanted
  std::string location = {};  // of a redirection
  enum class Page { as_it_is, begins, ends };
  Page page = Page::as_it_is;  // what becomes of the page's session, which a cookie stands for
};
/// A response that is known later: start() is to be called once; it calls `answer` once, from any thread.
struct Later {
  std::function<void(std::function<void(Ready)> answer)> start;
  bool on_disk = false;  // start() waits for the disk: not on an I/O thread
};
struct Stream {
  std::string content_type;
  std::unique_ptr<BodySource> body;
};
/// The connection becomes a WebSocket that is told events.
struct Upgrade {};
using Reply = std::variant<Ready, Later, Stream, Upgrade>;

/// What a client asks for; the views live as long as the request.
struct Request {
  std::string_view method, target;
  std::string_view body = {};
  OperatorIdentity who = {};  // asks; anybody where no token is asked for
};

/// Whether a target is for everybody; all others want the operator's token.
bool is_public(std::string_view target);

/// What operators left here, beside what the station knows. Each may be null: nothing is kept, and nobody has a name.
struct OperatorRecords {
  std::shared_ptr<EventLog> log = {};
  std::shared_ptr<NoteBook> notes = {};
  OperatorRegistry* people = nullptr;
  std::function<void(const std::string& name)> on_revoked = {};  // ends what this operator still listens to
};

/// Calls only what is quick in Station, so that an I/O thread may call this. A Later holds on to the station and to
/// `robots`, which is null where none has to enrol. What changed something is written to the log, if there is one. Who
/// may not do what is asked is told so (403).
Reply route(const Request& request, Station& station, PointTiles& tiles, const OperatorLimits& limits, double uptime_s,
            RobotAdmin* robots = nullptr, const OperatorRecords& records = {});

/// What a route asks of who wants it.
Role role_for(std::string_view method, std::string_view path);

/// Method and path of every route, "{name}" for a piece of the path that may be anything; with its query parameters.
struct RouteName {
  std::string_view method, path;
  std::vector<std::string_view> parameters;
};
std::vector<RouteName> route_names();

/// An error as JSON, with the HTTP status that fits its code, or with the one given.
Ready error_reply(const Error& error);
Ready error_reply(int status, const Error& error);

}  // namespace headframe
