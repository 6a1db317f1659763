#include "client/uplink/uplink.hpp"

#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>

#include "client/uplink/kernel_queue.hpp"
#include "client/uplink/uplink_thread.hpp"

namespace headframe {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;
constexpr auto tick_every = std::chrono::milliseconds(500);
constexpr auto look_again = std::chrono::milliseconds(20);  // whether the kernel has sent what it holds

}  // namespace

void Uplink::Thread::read(const Link& l) {
  l->stream.async_read_some(asio::buffer(l->received), [this, l](const Code& code, std::size_t n) {
    if (l->over) return;
    if (code) return fail(l, "the connection broke", code);
    take(l, l->protocol.receive({l->received.data(), n}, Clock::now()));
    if (l->over) return;
    if (l->probed && l->protocol.answered()) choose(l);
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
    l->shut = true;  // everything is sent: the server reads to the end and closes
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

/// How many bytes a chunk may hold now: see chunk_bytes_at() and kernel_room().
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
    // A spare is not pinged while the link is silent, because its answer would come before the answer to a probe.
    if (!spare(l) || !doubtful()) take(l, l->protocol.tick(Clock::now()));
    if (l->over) return;
    doubt();
    pump(l);
    tick(l);
  });
}

void Uplink::Thread::take(const Link& l, const std::vector<UplinkEvent>& events) {
  for (const auto& event : events) {
    if (l != link && std::holds_alternative<Welcomed>(event)) continue;  // a spare was welcomed
    if (l != link && std::holds_alternative<LinkEnded>(event)) return end(l, Again::never);
    if (const auto* policy = std::get_if<PolicyTold>(&event))
      bucket.set_rate(tighter(config.bytes_per_s, policy->bytes_per_s), Clock::now());
    if (const auto* welcomed = std::get_if<Welcomed>(&event)) {
      spares_allowed = welcomed->spares;
      capabilities = welcomed->capabilities;
      durable = 0;
      bucket.set_rate(config.bytes_per_s, Clock::now());  // until the server says otherwise
      up = true;
      servers.found(l->server);
      if (!pending_trigger.empty()) l->protocol.trigger(std::exchange(pending_trigger, {}));
    }
    if (const auto* keyframes = std::get_if<KeyframesDurable>(&event)) durable = std::max(durable, keyframes->up_to);
    if (const auto* told = std::get_if<SurroundingsMessage>(&event)) {
      take(l, *told);
      if (l->over) return;
      continue;
    }
    const auto* ended = std::get_if<LinkEnded>(&event);
    if (ended) end(l, ended->permanent ? Again::never : Again::later);
    on_event(event);
    if (ended) return;
    if (asks_where && std::holds_alternative<Welcomed>(event)) ask_where(l);
    if (std::holds_alternative<Welcomed>(event)) ask_around(l);
  }
}

void Uplink::Thread::ask_where(const Link& l) {
  if (!l->protocol.localize(asks_where) && asks_where) on_event(Localization{Localization::State::unsupported});
}

void Uplink::Thread::begin_close(bool complete) {
  closing = true;
  if (!carried() || !link->protocol.welcomed()) return io.stop();
  give_up_attempts();  // another connection would not know about the goodbye
  give_up_spares();
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

void Uplink::localize(bool asks) {
  asio::post(thread_->io, [t = thread_.get(), asks] {
    if (t->asks_where == asks) return;
    t->asks_where = asks;
    if (!t->carried() || !t->link->protocol.welcomed()) return;
    t->ask_where(t->link);
    t->pump(t->link);
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
