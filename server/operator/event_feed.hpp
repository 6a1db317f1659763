#pragma once
// GET /api/v1/events: WebSocket clients that are told what happens. Included by the .cpp files of this room only.

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "common/security/web_stream.hpp"
#include "server/operator/event_diff.hpp"
#include "server/operator/event_log.hpp"
#include "server/operator/operator_limits.hpp"
#include "server/security/operator_registry.hpp"

namespace headframe {

class EventSocket;

/// Looks at the station, writes the differences into the log, and tells clients of them: each first a snapshot, then
/// events that lead on from it. A client that reads too slowly loses what was queued and gets a snapshot instead, so
/// that its queue is bounded and what it knows is never wrong. Thread safe.
class EventFeed : public std::enable_shared_from_this<EventFeed> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  EventFeed(boost::asio::io_context& io, const Station& station, const EventLimits& limits,
            std::shared_ptr<EventLog> log, const OperatorRegistry* people = nullptr)
      : station_(station),
        limits_(limits),
        log_(std::move(log)),
        people_(people),
        timer_(boost::asio::make_strand(io)) {}

  /// Looks at the station from now on, and writes down what happens. Once.
  void start();

  /// Room for one more; a place that is taken is given back by the socket's end.
  bool take_place();
  void give_place();
  /// Takes over a connection whose request asks for an upgrade, and that has a place; until the operator's token ends.
  void serve(WebStream stream, Request request, const OperatorIdentity& who);
  /// Ends what this operator listens to, unless the token still stands.
  void end(const std::string& name);
  /// Ends all clients, after a last look for the log.
  void stop();

 private:
  friend class EventSocket;
  void join(const std::shared_ptr<EventSocket>& socket);
  void leave(const std::shared_ptr<EventSocket>& socket);
  void end_expired();
  void look_again();
  void look();
  std::vector<std::string> news(const std::shared_ptr<const StationLook>& now);

  const Station& station_;
  const EventLimits limits_;
  const std::shared_ptr<EventLog> log_;
  const OperatorRegistry* const people_;  // may be null
  std::uint64_t told_ = 0;                // the last entry of the log that clients know of
  std::mutex mutex_;
  boost::asio::steady_timer timer_;
  std::shared_ptr<const StationLook> last_;
  std::set<std::shared_ptr<EventSocket>> sockets_;
  std::atomic<std::size_t> places_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace headframe
