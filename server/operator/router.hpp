#pragma once
// From a request to what has to be done for it. No I/O: http_session does it.

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "server/operator/body_source.hpp"
#include "server/operator/robot_admin.hpp"
#include "server/operator/station.hpp"

namespace headframe {

struct OperatorLimits {
  std::size_t header_bytes = 8 * 1024;
  std::size_t body_bytes = 64 * 1024;
  std::size_t connections = 64;  // further ones are told 503
  double idle_s = 30;            // for a request to come, from the end of the one before it
  double write_s = 30;           // for each piece of a response to leave
  double wait_s = 3600;          // the most that ?wait= may ask for
};

/// A response that is known at once.
struct Ready {
  int status = 200;
  std::string content_type;
  std::string body;
  std::string allow;    // of a 405
  bool bearer = false;  // of a 401: a token is wanted
};
/// A response that is known later: start() is to be called once; it calls `answer` once, from any thread.
struct Later {
  std::function<void(std::function<void(Ready)> answer)> start;
};
struct Stream {
  std::string content_type;
  std::unique_ptr<BodySource> body;
};
using Reply = std::variant<Ready, Later, Stream>;

/// Whether a target is for everybody; all others want the operator's token.
bool is_public(std::string_view target);

/// Calls only what is quick in Station, so that an I/O thread may call this. A Later holds on to the station and to
/// `robots`, which is null where none has to enrol.
Reply route(std::string_view method, std::string_view target, Station& station, const OperatorLimits& limits,
            double uptime_s, RobotAdmin* robots = nullptr);

/// An error as JSON, with the HTTP status that fits its code, or with the one given.
Ready error_reply(const Error& error);
Ready error_reply(int status, const Error& error);

}  // namespace headframe
