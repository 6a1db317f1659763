// Which of several connections carries the session.
#include "client/uplink/kernel_queue.hpp"
#include "client/uplink/uplink_thread.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_spares_at_once = 2;  // connecting at once: they share a slow link with the keyframes
constexpr double resend_s = 1;                  // TCP's longest retransmission time here: see expect_losses()

}  // namespace

/// While the link is in doubt, the spares are probed; then other connections are tried beside it, as all may be dead.
void Uplink::Thread::doubt() {
  if (closing) return;
  if (!doubtful()) return calm_down();
  if (!probe_next() && carried() && attempts.empty()) connect();
}

/// The link answers again.
void Uplink::Thread::calm_down() {
  probing.cancel();
  for (const Link& l : spares)
    if (std::exchange(l->probed, false)) l->protocol.stand_by();
  keep_spares();
}

std::size_t Uplink::Thread::spares_wanted() const { return lossy ? std::min(config.spares, spares_allowed) : 0; }

void Uplink::Thread::keep_spares() {
  lossy = lossy || config.spares_from_loss <= 0 ||
          loses_packets(link->stream.socket().native_handle(), config.spares_from_loss);
  if (!link->protocol.welcomed() || spares.size() >= spares_wanted())
    give_up_attempts();
  else if (attempts.size() < std::min(most_spares_at_once, spares_wanted() - spares.size()) &&
           Clock::now() >= no_spare_before)
    connect();
}

/// Drops the oldest spare if there are too many.
void Uplink::Thread::stand_by(const Link& l) {
  if (!spares.empty() && spares.size() >= spares_wanted()) {
    discard(spares.front());
    spares.erase(spares.begin());
  }
  l->probed = false;
  l->protocol.stand_by();
  spares.push_back(l);
}

/// Probes one spare after the other, to spread TCP's retransmissions over their second. False: all have been probed.
bool Uplink::Thread::probe_next() {
  if (probing_now) return true;
  const auto unasked = [](const Link& l) { return !l->probed && l->protocol.welcomed(); };
  const auto found = std::find_if(spares.begin(), spares.end(), unasked);
  if (found == spares.end()) return false;
  const Link l = *found;
  l->probed = probing_now = true;
  probing.expires_after(seconds(resend_s / static_cast<double>(spares.size() + 1)));
  probing.async_wait([this](const Code&) {
    probing_now = false;
    doubt();
  });
  l->protocol.probe(durable);
  pump(l);
  return true;
}

/// A spare was answered: it carries the session from now on, unless the link has answered meanwhile.
void Uplink::Thread::choose(const Link& l) {
  if (closing || !doubtful()) return;
  const Link before = std::exchange(link, l);
  std::erase(spares, l);
  if (before->protocol.welcomed() && !before->over)
    stand_by(before);
  else
    discard(before);
  retry.cancel();
  if (!up) take(l, {Welcomed{spares_allowed, capabilities}, KeyframesDurable{durable}});
  take(l, l->protocol.take_over());
  if (asks_where) ask_where(l);
  ask_around(l);
  calm_down();
  pump(l);
}

void Uplink::Thread::give_up_spares() {
  for (const Link& l : std::exchange(spares, {})) discard(l);
}

}  // namespace headframe
