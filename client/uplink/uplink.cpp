#include "client/uplink/uplink.hpp"

#include <array>
#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <optional>
#include <thread>

#include "client/uplink/kernel_queue.hpp"
#include "client/uplink/pacing.hpp"
#include "common/security/link_stream.hpp"
#include "common/security/secret.hpp"
#include "common/security/tls.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;
using Code = boost::system::error_code;
using Clock = std::chrono::steady_clock;
constexpr auto tick_every = std::chrono::milliseconds(500);
constexpr auto look_again = std::chrono::milliseconds(20);  // whether the kernel has sent what it holds

Clock::duration seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

// All members but the atomics belong to the thread that runs `io`.
struct Uplink::Thread {
  /// One connection or attempt. Handlers hold it; `over` tells late ones to do nothing.
  struct Connection {
    Connection(asio::io_context& io, const UplinkConfig& config, const Hello& hello, const UplinkSource& source)
        : stream(io), pace(io), deadline(io), protocol(config.limits, hello, source, Clock::now()) {}
    LinkStream stream;
    asio::steady_timer pace, deadline;
    UplinkProtocol protocol;
    std::array<char, 16 * 1024> received{};
    std::string writing;  // the frame that is on its way
    bool up = false, over = false, shut = false;
  };
  using Link = std::shared_ptr<Connection>;

  Thread(const UplinkConfig& c, const Hello& h, const UplinkSource& s, std::function<void(const UplinkEvent&)> e)
      : config(c), hello(h), source(s), on_event(std::move(e)), bucket(c.bytes_per_s, Clock::now()) {
    if (!config.fingerprint.empty()) tls.emplace(config.fingerprint);
  }

  void connect();
  void shake_hands(const Link& link);
  void connected_to(const Link& link);
  void read(const Link& link);
  void pump(const Link& link);
  void pump_later(const Link& link);
  void write(const Link& link);
  void tick(const Link& link);
  void take(const Link& link, const std::vector<UplinkEvent>& events);
  void fail(const Link& link, const std::string& what, const Code& code);
  void end(const Link& link, bool permanent);
  static void discard(const Link& link);
  void retry_after(double s);
  void doubt();
  std::size_t room(const Link& link) const;
  void begin_close(bool complete);

  const UplinkConfig config;
  const Hello hello;
  const UplinkSource& source;
  const std::function<void(const UplinkEvent&)> on_event;
  asio::io_context io{1};
  std::optional<PinnedTls> tls;  // none: in the clear
  asio::steady_timer retry{io};
  tcp::resolver resolver{io};
  TokenBucket bucket;
  Backoff backoff{config.retry_first_s, config.retry_most_s, std::random_device{}()};
  Link link;     // the one that carries the session; null or over: none does
  Link attempt;  // being made; beside a link in doubt, or without one
  std::string pending_trigger;
  bool closing = false;
  std::atomic<bool> up{false};
  std::atomic<std::uint64_t> bytes_sent{0};
  std::thread runner;
};

void Uplink::Thread::connect() {
  if (attempt) return;
  attempt = std::make_shared<Connection>(io, config, hello, source);
  attempt->deadline.expires_after(seconds(config.connect_s));
  attempt->deadline.async_wait([this, l = attempt](const Code& code) {
    if (!code) fail(l, "no connection", asio::error::timed_out);
  });
  resolver.async_resolve(config.host, std::to_string(config.port), [this, l = attempt](const Code& code, auto found) {
    if (l->over) return;
    if (code) return fail(l, "can not be resolved", code);
    asio::async_connect(l->stream.socket(), found, [this, l](const Code& fault, const tcp::endpoint&) {
      if (l->over) return;
      if (fault) return fail(l, "no connection", fault);
      Code ignored;
      l->stream.socket().set_option(tcp::no_delay(true), ignored);
      expect_losses(l->stream.socket().native_handle());
      tls ? shake_hands(l) : connected_to(l);
    });
  });
}

void Uplink::Thread::shake_hands(const Link& l) {
  l->stream.async_handshake(tls->context(), asio::ssl::stream_base::client, [this, l](const Code& fault) {
    if (l->over) return;
    if (fault && !tls->other().empty())
      return fail(l, "not the server that is pinned: its fingerprint is " + to_hex(tls->other()), fault);
    if (fault) return fail(l, "no TLS", fault);
    connected_to(l);
  });
}

void Uplink::Thread::connected_to(const Link& l) {
  if (link) discard(link);  // in doubt: the server replaces it too
  link = std::exchange(attempt, nullptr);
  l->up = true;
  read(l);
  pump(l);
  tick(l);
}

/// While the link is in doubt another is tried beside it; when it speaks again, that is given up.
void Uplink::Thread::doubt() {
  if (!link || link->over) return;
  const bool doubtful = link->protocol.doubtful(Clock::now());
  if (doubtful && !closing) return connect();
  if (attempt && !doubtful) discard(std::exchange(attempt, nullptr));
}

void Uplink::Thread::read(const Link& l) {
  l->stream.async_read_some(asio::buffer(l->received), [this, l](const Code& code, std::size_t n) {
    if (l->over) return;
    if (code) return fail(l, "the connection broke", code);
    take(l, l->protocol.receive({l->received.data(), n}, Clock::now()));
    if (l->over) return;
    doubt();
    pump(l);
    read(l);
  });
}

// One frame is in flight at a time, so the next one is chosen by priority at the last moment.
void Uplink::Thread::pump(const Link& l) {
  if (l->over || !l->up || !l->writing.empty()) return;
  std::vector<UplinkEvent> events;
  const std::size_t chunk_bytes = room(l);
  auto frame = l->protocol.next_frame(Clock::now(), chunk_bytes, events);
  take(l, events);
  if (l->over) return;
  if (!frame) {
    if (chunk_bytes == 0) pump_later(l);
    if (!closing || l->shut) return;
    l->shut = true;  // all is said: the server reads to the end and hangs up
    Code ignored;
    l->stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
    return;
  }
  l->pace.cancel();
  l->writing = std::move(*frame);
  const auto wait = bucket.take(l->writing.size(), Clock::now());
  if (wait.count() <= 0) return write(l);
  l->pace.expires_after(seconds(wait.count()));
  l->pace.async_wait([this, l](const Code& code) {
    if (!code && !l->over) write(l);
  });
}

/// What a chunk may hold now: see chunk_bytes_at() and kernel_room().
std::size_t Uplink::Thread::room(const Link& l) const {
  const std::size_t paced = chunk_bytes_at(bucket.bytes_per_s());
  return std::min(paced, kernel_room(l->stream.socket().native_handle(), paced));
}

void Uplink::Thread::pump_later(const Link& l) {
  l->pace.expires_after(look_again);
  l->pace.async_wait([this, l](const Code& code) {
    if (!code) pump(l);
  });
}

void Uplink::Thread::write(const Link& l) {
  asio::async_write(l->stream, asio::buffer(l->writing), [this, l](const Code& code, std::size_t n) {
    bytes_sent += n;
    if (l->over) return;
    if (code) return fail(l, "the connection broke", code);
    l->writing.clear();
    pump(l);
  });
}

void Uplink::Thread::tick(const Link& l) {
  l->deadline.expires_after(tick_every);
  l->deadline.async_wait([this, l](const Code& code) {
    if (code || l->over) return;
    take(l, l->protocol.tick(Clock::now()));
    if (l->over) return;
    doubt();
    pump(l);
    tick(l);
  });
}

void Uplink::Thread::take(const Link& l, const std::vector<UplinkEvent>& events) {
  for (const auto& event : events) {
    if (const auto* policy = std::get_if<PolicyTold>(&event))
      bucket.set_rate(tighter(config.bytes_per_s, policy->bytes_per_s), Clock::now());
    if (std::holds_alternative<Welcomed>(event)) {
      bucket.set_rate(config.bytes_per_s, Clock::now());  // until the server says otherwise
      up = true;
      backoff.reset();
      if (!pending_trigger.empty()) l->protocol.trigger(std::exchange(pending_trigger, {}));
    }
    const auto* ended = std::get_if<LinkEnded>(&event);
    if (ended) end(l, ended->permanent);
    on_event(event);
    if (ended) return;
  }
}

void Uplink::Thread::fail(const Link& l, const std::string& what, const Code& code) {
  if (l->over) return;
  const bool beside = l == attempt && link && !link->over;
  if (l == attempt && code == asio::error::timed_out) {  // it took its time: the next one at once
    discard(std::exchange(attempt, nullptr));
    if (closing && !beside) return io.stop();
    if (!closing && !beside) retry_after(0);
    if (beside) doubt();
  } else {
    end(l, false);
  }
  const std::string where = config.host + ":" + std::to_string(config.port);
  if (!closing && !beside)
    on_event(LinkEnded{{ErrorCode::unavailable, where + ": " + what + ": " + tls_trouble(code)}, false});
}

void Uplink::Thread::discard(const Link& l) {
  if (l->over) return;
  l->over = true;
  Code ignored;
  l->stream.socket().close(ignored);
  l->pace.cancel();
  l->deadline.cancel();
}

void Uplink::Thread::end(const Link& l, bool permanent) {
  if (l->over) return;
  discard(l);
  if (l == attempt) attempt.reset();
  if (link && !link->over) return;  // an attempt beside it: tick() tries again as long as there is doubt
  up = false;
  if (permanent && attempt) discard(std::exchange(attempt, nullptr));
  if (closing) return io.stop();
  if (!permanent && !attempt) retry_after(backoff.next_s());
}

void Uplink::Thread::retry_after(double s) {
  retry.expires_after(seconds(s));
  retry.async_wait([this](const Code& code) {
    if (!code && !closing) connect();
  });
}

void Uplink::Thread::begin_close(bool complete) {
  closing = true;
  if (!link || link->over || !link->protocol.welcomed()) return io.stop();
  link->protocol.goodbye(complete);
  retry.expires_after(seconds(config.close_s));
  retry.async_wait([this](const Code&) { io.stop(); });
  pump(link);
}

Uplink::Uplink(const UplinkConfig& config, const Hello& hello, const UplinkSource& source,
               std::function<void(const UplinkEvent&)> on_event)
    : thread_(std::make_unique<Thread>(config, hello, source, std::move(on_event))) {
  thread_->runner = std::thread([t = thread_.get()] {
    const auto work = asio::make_work_guard(t->io);  // also while a permanent error leaves nothing to do
    t->connect();
    t->io.run();
  });
}

void Uplink::wake() {
  asio::post(thread_->io, [t = thread_.get()] {
    if (t->link) t->pump(t->link);
  });
}

void Uplink::trigger(const std::string& reason) {
  asio::post(thread_->io, [t = thread_.get(), reason] {
    if (t->link && t->link->protocol.welcomed()) {
      t->link->protocol.trigger(reason);
      t->pump(t->link);
    } else {
      t->pending_trigger = reason;
    }
  });
}

void Uplink::close(bool complete) {
  if (!thread_->runner.joinable()) return;
  asio::post(thread_->io, [t = thread_.get(), complete] { t->begin_close(complete); });
  thread_->runner.join();
}

bool Uplink::connected() const { return thread_->up; }
std::uint64_t Uplink::bytes_sent() const { return thread_->bytes_sent; }
Uplink::~Uplink() { close(false); }

}  // namespace headframe
