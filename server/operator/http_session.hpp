#pragma once
// One HTTP connection: reads requests, calls the router, writes responses. Included only by the .cpp files of this
// room.

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "common/security/web_stream.hpp"
#include "server/operator/event_feed.hpp"
#include "server/operator/http_rules.hpp"
#include "server/operator/operator_access.hpp"
#include "server/operator/operator_limits.hpp"
#include "server/operator/router.hpp"
#include "server/security/operator_guard.hpp"
#include "server/security/page_sessions.hpp"
#include "server/security/relay_header.hpp"

namespace headframe {

class HttpSession;

/// State that all connections share. Thread safe.
class HttpShared : public std::enable_shared_from_this<HttpShared> {
 public:
  HttpShared(boost::asio::io_context& io, Station& the_station, const OperatorLimits& the_limits,
             const OperatorAccess& access)
      : station(the_station),
        limits(the_limits),
        guard(access.token, {}, access.people),
        asks_token(!access.token.empty()),
        relay_key(headframe::relay_key(access.token)),
        tls(access.tls),
        strangers(the_limits.requests),
        operators(the_limits.requests),
        robots(access.robots),
        tiles(the_station),
        log(std::make_shared<EventLog>(access.log)),
        events(std::make_shared<EventFeed>(io, the_station, the_limits.events, log, access.people)),
        records{log, std::make_shared<NoteBook>(access.notes), access.people,
                [this](const std::string& name) { events->end(name); }} {}

  Station& station;
  const OperatorLimits limits;
  OperatorGuard guard;
  PageSessions pages;
  const bool asks_token;
  const std::string relay_key;           // authenticates standby servers that relay operators' connections
  boost::asio::ssl::context* const tls;  // null: plain HTTP
  AttemptLimiter strangers, operators;   // limit requests per address
  RobotAdmin* const robots;              // may be null
  const std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  PointTiles tiles;
  const std::shared_ptr<EventLog> log;
  const std::shared_ptr<EventFeed> events;
  const OperatorRecords records;
  boost::asio::thread_pool disk{2};  // runs BodySource::next()

  /// Starts a connection. If limits.connections are being served already, one without the token is closed to make room:
  /// the one that has waited longest for a request, or if none waits and a token is required, the one whose request
  /// came first. If there is none, the new client is answered 503; it is dropped if limits.connections clients are
  /// being answered so already.
  void accept(boost::asio::ip::tcp::socket socket);
  /// Call when a connection begins to wait for a request, or begins to serve one. has_token: it has shown the token.
  void note(const std::shared_ptr<HttpSession>& session, bool waits, bool has_token);
  /// Sets the host name on which the API listens; call before the first connection.
  void serve_under(const std::string& host) { host_ = host; }
  const std::string& served_under() const { return host_; }
  void forget(const std::shared_ptr<HttpSession>& session);
  /// Closes all connections, cancels the work on the disk, and accepts no new connections. Waits for disk work that is
  /// running.
  void stop();

 private:
  struct Seat {
    std::uint64_t since = 0;  // when it connected, or last began to wait or to serve; a counter
    bool turned_away = false, waits = true, has_token = false;
  };
  bool make_room();

  std::string host_;
  std::mutex mutex_;
  std::map<std::shared_ptr<HttpSession>, Seat> sessions_;
  std::uint64_t events_seen_ = 0;
  bool stopped_ = false;
};

/// Everything except start() and close() runs on the strand of its socket.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, std::shared_ptr<HttpShared> shared, bool turn_away);
  void start();
  void close();

 private:
  static constexpr double linger_s = 2;
  static constexpr auto look_every = std::chrono::seconds(1);
  using Code = boost::beast::error_code;
  using Piece = Result<std::optional<std::string>>;

  void meet();
  void meet_relay();
  void begin();
  void detect_tls();
  void read();
  void read_header();
  void read_body();
  void on_read(Code code);
  void refuse(Code code);
  std::optional<Ready> in_the_clear() const;
  std::optional<Ready> foreign() const;
  std::optional<Ready> turned_down();
  std::string credentials_of_page(std::chrono::steady_clock::time_point now) const;
  std::string page_cookie(Ready::Page page) const;
  std::optional<Ready> too_many(AttemptLimiter& requests, AttemptLimiter::Time now) const;
  void perform(Reply reply);
  void upgrade();
  void send(Ready ready);
  void answer_later(const Later& later);
  void pull();
  void on_piece(Piece piece);
  void write_piece(std::optional<std::string> piece);
  void on_written();
  void allow(double seconds) { tcp().expires_after(std::chrono::milliseconds(std::llround(seconds * 1000))); }
  boost::beast::tcp_stream& tcp() { return stream_.next_layer(); }
  void linger();
  void drain(std::size_t drained_bytes);
  void finish();
  void watch_client();
  bool client_gone();

  WebStream stream_;
  boost::asio::steady_timer look_;  // limits the wait for the first byte, later polls whether the client is there
  boost::asio::ip::address from_;
  const std::shared_ptr<HttpShared> shared_;
  const bool turn_away_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::string header_;  // as received
  bool has_token_ = false, keep_alive_ = false, handed_over_ = false;
  OperatorIdentity who_;               // who sent the request
  std::string credentials_;            // shown with the request, or when the page signed in
  bool head_sent_ = false;             // of the Stream that is being sent
  std::optional<std::uint64_t> left_;  // bytes of it that are still to be sent; nullopt: it is sent in chunks
  std::unique_ptr<Stream> body_;
  std::string head_, piece_;
  std::shared_ptr<void> response_;  // kept alive until it is written
};

}  // namespace headframe
