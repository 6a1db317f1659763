#pragma once
// The implementation of the uplink: uplink_thread.cpp makes and ends connections, uplink_spares.cpp decides which one
// carries the session, uplink.cpp sends over them.

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "client/uplink/pacing.hpp"
#include "client/uplink/server_list.hpp"
#include "client/uplink/surroundings_book.hpp"
#include "client/uplink/uplink.hpp"
#include "common/security/link_stream.hpp"
#include "common/security/tls.hpp"

namespace headframe {

// All members but the atomics belong to the thread that runs `io`.
struct Uplink::Thread {
  using Clock = std::chrono::steady_clock;
  using Code = boost::system::error_code;

  /// One connection or attempt. Handlers share it; `over` tells late handlers to do nothing.
  struct Connection {
    Connection(Thread& thread, std::size_t to)
        : server(to),
          stream(thread.io),
          pace(thread.io),
          deadline(thread.io),
          protocol(thread.config.limits, thread.hello, thread.source, Clock::now()) {}
    const std::size_t server;  // of the list
    LinkStream stream;
    boost::asio::steady_timer pace, deadline;
    UplinkProtocol protocol;
    std::array<char, 16 * 1024> received{};
    std::string writing;  // the frame that is on its way
    bool up = false, over = false, shut = false, probed = false;
  };
  using Link = std::shared_ptr<Connection>;

  Thread(const UplinkConfig& c, const Hello& h, const UplinkSource& s, std::function<void(const UplinkEvent&)> e)
      : config(c), hello(h), source(s), on_event(std::move(e)), bucket(c.bytes_per_s, Clock::now()) {
    if (!config.fingerprint.empty()) tls.emplace(config.fingerprint);
  }

  void connect();
  void next_attempt();
  void give_up_attempts();
  void shake_hands(const Link& link);
  void connected_to(const Link& link);
  void read(const Link& link);
  void pump(const Link& link);
  void pump_later(const Link& link);
  void write(const Link& link);
  void tick(const Link& link);
  void take(const Link& link, const std::vector<UplinkEvent>& events);
  void fail(const Link& link, const std::string& what, const Code& code);
  enum class Again { at_once, later, never };
  void end(const Link& link, Again again);
  static void discard(const Link& link);
  void retry_after(double s);
  void doubt();
  bool doubtful() const { return !carried() || link->protocol.doubtful(Clock::now()); }
  std::size_t spares_wanted() const;
  void keep_spares();
  void stand_by(const Link& link);
  bool probe_next();
  void calm_down();
  void choose(const Link& link);
  void give_up_spares();
  bool carried() const { return link && !link->over; }
  bool spare(const Link& l) const { return std::find(spares.begin(), spares.end(), l) != spares.end(); }
  std::size_t room(const Link& link) const;
  void ask_where(const Link& link);
  void ask_around(const Link& link);
  void take(const Link& link, const SurroundingsMessage& told);
  template <class Change>
  void change_questions(Change change);
  void begin_close(bool complete);

  static constexpr std::size_t most_attempts = 4;
  static constexpr double spare_again_s = 10;  // after a spare was closed by the server

  static std::vector<Endpoint> servers_of(const UplinkConfig& config) {
    std::vector<Endpoint> all{{config.host, config.port}};
    all.insert(all.end(), config.more_servers.begin(), config.more_servers.end());
    return all;
  }
  static Clock::duration seconds(double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
  }

  const UplinkConfig config;
  const Hello hello;
  const UplinkSource& source;
  const std::function<void(const UplinkEvent&)> on_event;
  boost::asio::io_context io{1};
  std::optional<PinnedTls> tls;  // none: in the clear
  boost::asio::steady_timer retry{io}, next{io}, probing{io};
  boost::asio::ip::tcp::resolver resolver{io};
  TokenBucket bucket;
  ServerList servers{servers_of(config), {config.retry_first_s, config.retry_most_s, std::random_device{}()}};
  Link link;                              // the one that carries the session; null or over: there is none
  std::vector<Link> attempts;             // being connected: beside a link in doubt, as a spare, or if there is no link
  std::vector<Link> spares;               // connected, beside the link
  std::size_t spares_allowed = 0;         // by the server
  std::vector<std::string> capabilities;  // of the server
  std::uint64_t durable = 0;              // keyframes durable on the server, on any connection
  bool lossy = false;                     // the link has lost packets, so spares are worth their pings
  bool probing_now = false;               // a spare was probed; the next is probed later
  Clock::time_point no_spare_before{};
  std::string pending_trigger;
  bool asks_where = false;
  SurroundingsBook book;
  bool closing = false;
  std::atomic<bool> up{false};
  std::atomic<std::uint64_t> bytes_sent{0};
  std::thread runner;
};

}  // namespace headframe
