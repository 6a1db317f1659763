#pragma once
// GET /api/v1/events: sends events to WebSocket clients. Included only by the .cpp files of this room.

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

/// Polls the station, writes the differences to the log, and sends them to the clients. A client first gets a snapshot,
/// then the events that follow it. If a client reads too slowly, its queued events are replaced by a snapshot; so its
/// queue is bounded, and it never ends up with a wrong state. Thread safe.
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

  /// Starts polling and logging. Call once.
  void start();

  /// Reserves a place for one more client; false: there is none. The client's socket gives it back when it is
  /// destroyed.
  bool take_place();
  void give_place();
  /// Takes over a connection whose request asks for a WebSocket upgrade and which has a place. The connection ends at
  /// the latest with the operator's token.
  void serve(WebStream stream, Request request, const OperatorIdentity& who);
  /// Ends all event streams of this operator.
  void end(const std::string& name);
  /// Disconnects all clients, after polling once more for the log.
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
  std::uint64_t told_ = 0;                // the last entry of the log that was sent to clients
  std::mutex mutex_;
  boost::asio::steady_timer timer_;
  std::shared_ptr<const StationLook> last_;
  std::set<std::shared_ptr<EventSocket>> sockets_;
  std::atomic<std::size_t> places_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace headframe
