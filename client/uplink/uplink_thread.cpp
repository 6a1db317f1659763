#include "client/uplink/uplink_thread.hpp"

#include <boost/asio/connect.hpp>

#include "client/uplink/kernel_queue.hpp"
#include "common/security/secret.hpp"

namespace headframe {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;

}  // namespace

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

}  // namespace headframe
