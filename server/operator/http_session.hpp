#pragma once
// One HTTP connection: reads requests, does what the router says, writes responses. Included by the .cpp files of this
// room only.

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

/// What all connections share. Thread safe.
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
  const std::string relay_key;           // of the servers that pass operators on
  boost::asio::ssl::context* const tls;  // null: plain HTTP
  AttemptLimiter strangers, operators;   // requests, by address
  RobotAdmin* const robots;              // may be null
  const std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  PointTiles tiles;
  const std::shared_ptr<EventLog> log;
  const std::shared_ptr<EventFeed> events;
  const OperatorRecords records;
  boost::asio::thread_pool disk{2};  // runs BodySource::next()

  /// Starts a connection. Where limits.connections are served already the one makes room that has waited longest for a
  /// request, of those that have not shown the token; and where there is none the new one is told 503, or dropped when
  /// as many are being told so.
  void accept(boost::asio::ip::tcp::socket socket);
  /// It waits for a request, or serves one; it has shown the token.
  void note(const std::shared_ptr<HttpSession>& session, bool waits, bool has_token);
  /// The name that the API listens under; before the first connection.
  void serve_under(const std::string& host) { host_ = host; }
  const std::string& served_under() const { return host_; }
  void forget(const std::shared_ptr<HttpSession>& session);
  /// Ends all connections and the work on disk, and takes no new ones. Waits for the piece being read.
  void stop();

 private:
  struct Seat {
    std::uint64_t since = 0;  // when it came, or began to wait: greater is later
    bool turned_away = false, waits = true, has_token = false;
  };
  bool make_room();

  std::string host_;
  std::mutex mutex_;
  std::map<std::shared_ptr<HttpSession>, Seat> sessions_;
  std::uint64_t events_seen_ = 0;
  bool stopped_ = false;
};

/// Everything but start() and close() runs on the strand of its socket.
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
  boost::asio::steady_timer look_;  // whether it has said anything; later: whether it is still there
  boost::asio::ip::address from_;
  const std::shared_ptr<HttpShared> shared_;
  const bool turn_away_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::string header_;  // as it came
  bool has_token_ = false, keep_alive_ = false, handed_over_ = false;
  OperatorIdentity who_;               // of the request
  std::string credentials_;            // that were shown with it, or when the page signed in
  bool head_sent_ = false;             // of the Stream under way
  std::optional<std::uint64_t> left_;  // bytes of it that are still to come; none: it is sent in chunks
  std::unique_ptr<Stream> body_;
  std::string head_, piece_;
  std::shared_ptr<void> response_;  // lives until it is written
};

}  // namespace headframe
