#include "client/uplink/uplink_thread.hpp"

#include <boost/asio/connect.hpp>

#include "common/security/secret.hpp"
#include "common/wire/lossy_link.hpp"

namespace headframe {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;

}  // namespace

void Uplink::Thread::connect() {
  const bool is_spare = carried() && !doubtful();  // a spare is useless at another server
  const auto l = std::make_shared<Connection>(*this, is_spare ? link->server : servers.take());
  attempts.push_back(l);
  l->deadline.expires_after(seconds(doubtful() ? config.connect_s : config.spare_connect_s));
  l->deadline.async_wait([this, l](const Code& code) {
    if (!code) fail(l, "no connection", asio::error::timed_out);
  });
  next_attempt();
  const Endpoint& to = servers.at(l->server);
  resolver.async_resolve(to.host, std::to_string(to.port), [this, l](const Code& code, auto found) {
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

/// Starts another attempt beside a slow one, at the next server if there are several: on a link that loses packets the
/// last attempt is often the first to connect.
void Uplink::Thread::next_attempt() {
  next.expires_after(seconds(config.connect_again_s));
  next.async_wait([this](const Code& code) {
    if (code || closing || attempts.empty()) return;
    // An attempt for a spare is not urgent.
    doubtful() && attempts.size() < most_attempts ? connect() : next_attempt();
  });
}

void Uplink::Thread::connected_to(const Link& l) {
  std::erase(attempts, l);
  l->up = true;
  if (carried() && link->protocol.welcomed() && spares_wanted() > 0) {
    stand_by(l);
  } else {
    if (link) discard(link);  // the link was in doubt; the server replaces it too
    link = l;
    give_up_attempts();
  }
  read(l);
  pump(l);
  tick(l);
}

void Uplink::Thread::give_up_attempts() {
  next.cancel();
  for (const Link& l : std::exchange(attempts, {})) discard(l);
}

void Uplink::Thread::fail(const Link& l, const std::string& what, const Code& code) {
  if (l->over) return;
  const bool beside = (std::erase(attempts, l) > 0 && carried()) || spare(l);
  end(l, code == asio::error::timed_out ? Again::at_once : Again::later);  // a timeout has taken long enough
  const std::string where = to_string(servers.at(l->server));
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

/// later: after the pause that is due.
void Uplink::Thread::end(const Link& l, Again again) {
  if (l->over) return;
  discard(l);
  if (std::erase(spares, l) > 0) {
    no_spare_before = Clock::now() + seconds(spare_again_s);
    return;
  }
  if (carried()) return;  // an attempt beside the link; tick() tries again while there is doubt
  up = false;
  const bool never = again == Again::never;
  const double pause_s = servers.failed(l->server);
  if (never) give_up_attempts();
  if (never || closing) give_up_spares();
  if (closing) return io.stop();
  if (!never && attempts.empty()) retry_after(again == Again::later ? pause_s : 0);
  doubt();
}

void Uplink::Thread::retry_after(double s) {
  retry.expires_after(seconds(s));
  retry.async_wait([this](const Code& code) {
    if (!code && !closing) connect();
  });
}

}  // namespace headframe
