#pragma once
// Maps a request to what has to be done for it. Does no I/O on connections; HttpSession does that.

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

/// A response that is available at once.
struct Ready {
  int status = 200;
  std::string content_type;
  std::string body;
  std::string allow;          // for a 405: the allowed methods
  bool gzip = false;          // the body is compressed
  bool bearer = false;        // for a 401: a bearer token is required
  std::string location = {};  // for a redirection
  enum class Page { as_it_is, begins, ends };
  Page page = Page::as_it_is;  // whether a page session, identified by a cookie, begins or ends
};
/// A response that is available later. Call start() once; it calls `answer` once, from any thread.
struct Later {
  std::function<void(std::function<void(Ready)> answer)> start;
  bool on_disk = false;  // start() waits for the disk: do not call it on an I/O thread
};
struct Stream {
  std::string content_type;
  std::unique_ptr<BodySource> body;
};
/// The connection becomes a WebSocket that receives events.
struct Upgrade {};
using Reply = std::variant<Ready, Later, Stream, Upgrade>;

/// A request; its views stay valid as long as the request is handled.
struct Request {
  std::string_view method, target;
  std::string_view body = {};
  OperatorIdentity who = {};  // who sent it; the default if no token is required
};

/// Whether a target needs no token.
bool is_public(std::string_view target);

/// Records of operators, which the station does not have. Each may be null: then nothing is kept, or there are no named
/// operators.
struct OperatorRecords {
  std::shared_ptr<EventLog> log = {};
  std::shared_ptr<NoteBook> notes = {};
  OperatorRegistry* people = nullptr;
  std::function<void(const std::string& name)> on_revoked = {};  // ends this operator's event streams
};

/// Handles a request. Calls only fast functions of the station, so it may run on an I/O thread; a Later that waits for
/// the disk says so (on_disk). A Later refers to the station and to `robots`, which is null if robots need not enrol.
/// Successful changes are logged if there is a log. 403: the operator's role does not allow the request.
Reply route(const Request& request, Station& station, PointTiles& tiles, const OperatorLimits& limits, double uptime_s,
            RobotAdmin* robots = nullptr, const OperatorRecords& records = {});

/// The least role that a route requires.
Role role_for(std::string_view method, std::string_view path);

/// Method and path of every route, with its query parameters. "{name}" stands for one segment of the path.
struct RouteName {
  std::string_view method, path;
  std::vector<std::string_view> parameters;
};
std::vector<RouteName> route_names();

/// An error as JSON, with the HTTP status that corresponds to its code, or with the given one.
Ready error_reply(const Error& error);
Ready error_reply(int status, const Error& error);

}  // namespace headframe
