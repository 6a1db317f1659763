#include "server/membership.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <thread>

#include "common/printable.hpp"
#include "common/security/secret.hpp"
#include "server/relay_target.hpp"
#include "server/security/operator_guard.hpp"
#include "server/security/relay_header.hpp"
#include "server/store/postgres_writer.hpp"

namespace headframe {
namespace {

/// Of its host and data directory: there is no second one there.
std::string given_name(const std::filesystem::path& data) {
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host = {'?'};
  std::error_code ignored;
  return std::string(host.data()) + ":" + std::filesystem::absolute(data, ignored).lexically_normal().string();
}

/// Of the running system and its network namespace, which containers on one machine have of their own. Empty: unknown.
std::string loopback_name() {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  std::error_code fault;
  const auto space = std::filesystem::read_symlink("/proc/self/ns/net", fault);
  return boot.empty() || fault ? "" : boot + " " + space.string();
}

bool wait_anyway(const Error&, std::chrono::milliseconds pause) {
  std::this_thread::sleep_for(pause);
  return true;
}

}  // namespace

Membership::Membership(ServerOptions options) : options_(std::move(options)) {
  card_.id = random_mark();
  card_.loopback = loopback_name();
  card_.name = printable(options_.config.name.empty() ? given_name(options_.data) : options_.config.name);
  const std::string& url = options_.config.store_url;
  if (const auto database = postgres_name(url); !url.empty() && database)
    presence_ = std::make_unique<PostgresPresence>(
        url, *database,
        [told = options_.on_taken_over](const Error& why) {
          if (told) told(why);
        },
        [this] { return work(); });
}

Membership::~Membership() { end_standby(); }

Result<void> Membership::reserve_ports() {
  if (!options_.config.standby) return {};
  for (Endpoint* endpoint : {&options_.listen, &options_.http}) {
    auto port = ReservedPort::at(*endpoint);
    if (!port) return tl::unexpected(port.error());
    *endpoint = port->endpoint();
    ports_.push_back(std::move(*port));
  }
  return {};
}

PostgresOpening Membership::opening() {
  PostgresOpening opening{options_.wait_for_database, card_.id, {}};
  if (options_.config.standby)
    opening.standby = StandbyPlan{[this](const auto& active) { return begin_to_wait(active); },
                                  options_.wait_for_turn ? options_.wait_for_turn : wait_anyway};
  return opening;
}

Result<void> Membership::begin_to_wait(const std::optional<ServerCard>& active) {
  if (!options_.insecure) {
    if (auto fit = fit_to_stand_by(options_.data, active); !fit) return fit;
    const auto known = known_by(options_.data);
    if (!known) return tl::unexpected(known.error());
    card_.fingerprint = known->fingerprint;
    card_.token_digest = known->token_digest;
  }
  card_.robots = to_string(options_.config.public_address.value_or(options_.listen));
  card_.http = operators_at(options_.http);
  presence_->start(card_);
  if (auto done = begin_to_relay(); !done) return done;
  const std::string& url = options_.config.store_url;
  if (options_.config.helps) {
    const std::lock_guard lock(mutex_);
    helper_ = std::make_unique<PairHelper>(url, postgres_name(url).value(), card_.id, options_.config.merge);
  }
  if (options_.on_standby) options_.on_standby(options_.listen, options_.http);
  return {};
}

Result<void> Membership::begin_to_relay() {
  const auto token = options_.insecure ? Result<std::string>("") : operator_token(options_.data);
  if (!token) return tl::unexpected(token.error());
  for (const Door door : {Door::robots, Door::operators}) {
    const Endpoint at = door == Door::robots ? options_.listen : options_.http;
    auto relay = std::make_unique<Relay>(relay_key(*token), [presence = presence_.get(), door, at] {
      return relay_target(presence->servers(), door, at);
    });
    if (auto listening = relay->listen(at); !listening) return tl::unexpected(listening.error());
    const std::lock_guard lock(mutex_);
    relays_.push_back(std::move(relay));
  }
  return {};
}

void Membership::end_standby() {
  if (helper_) helper_->stop();
  for (const auto& relay : relays_) relay->stop();
}

StandbyWork Membership::work() const {
  const std::lock_guard lock(mutex_);
  StandbyWork work;
  for (const auto& relay : relays_) work.relayed += relay->connections();
  if (!helper_) return work;
  const PairHelper::Work now = helper_->work();
  work.searched = static_cast<std::int64_t>(now.searched);
  work.searches_a = now.a;
  work.searches_b = now.b;
  return work;
}

std::unique_ptr<PairHelpers> Membership::helpers() const {
  if (!presence_) return nullptr;
  const std::string& url = options_.config.store_url;
  return std::make_unique<PostgresPairHelpers>(url, postgres_name(url).value(), [this] {
    const auto all = presence_->servers();
    return std::any_of(all.begin(), all.end(), [](const ServerRecord& s) { return !s.is_self && !s.is_active; });
  });
}

/// To every address of this machine nobody can connect from elsewhere; where robots come, operators may, too.
std::string Membership::operators_at(const Endpoint& http) const {
  const auto& known = options_.config.public_address;
  return to_string(is_any_address(http) && known ? Endpoint{known->host, http.port} : http);
}

void Membership::serves(const Endpoint& robots, const Endpoint& http, const std::string& fingerprint,
                        const std::string& token) {
  ports_.clear();
  const std::lock_guard lock(mutex_);
  card_.robots = to_string(options_.config.public_address.value_or(robots));
  card_.http = operators_at(http);
  card_.fingerprint = fingerprint;
  card_.token_digest = token.empty() ? "" : sha256(token);
  since_s_ = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  if (!presence_) return;
  presence_->start(card_);
  presence_->become_active();
}

std::vector<ServerRecord> Membership::servers() const {
  const std::lock_guard lock(mutex_);
  if (presence_) return presence_->servers();
  return {{card_.name, card_.robots, card_.http, true, true, since_s_, 0, 0}};
}

}  // namespace headframe
