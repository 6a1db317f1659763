#include "server/map_merge_server.hpp"

#include <google/protobuf/stubs/logging.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <fstream>
#include <optional>
#include <thread>

#include "server/membership.hpp"
#include "server/net/robot_listener.hpp"
#include "server/operator/operator_api.hpp"
#include "server/security/operator_guard.hpp"
#include "server/security/operator_registry.hpp"
#include "server/security/relay_header.hpp"
#include "server/security/robot_gate.hpp"
#include "server/security/server_identity.hpp"
#include "server/station/robot_desk.hpp"
#include "server/station/room_watch.hpp"
#include "server/station/station_view.hpp"
#include "server/store/sqlite_store.hpp"

namespace headframe {
namespace {

constexpr std::size_t mib = 1024UL * 1024;

}  // namespace

/// Order of life: what is below uses what is above. stop() goes from the peers inwards.
struct MapMergeServer::Parts {
  Parts(const ServerOptions& o, std::unique_ptr<Membership> member, std::unique_ptr<Store> opened,
        std::optional<boost::asio::ssl::context> door, WorkMark mark, RevocationLog revoked)
      : options(o),
        membership(std::move(member)),
        revocations(std::move(revoked)),
        store(std::move(opened)),
        helpers(membership->helpers()),
        worker(make_pipeline(o.config.merge, helpers.get()), *store, o.config.schedule, std::move(mark)),
        hub(*store, worker, o.config.limits),
        notes(*store),
        gate(*store,
             {{},
              [this](const std::string& robot, const std::string& why) { hub.end_robot(robot, why); },
              [this](const std::string& robot, std::uint64_t kib_s) { hub.set_rate(robot, kib_s * 1024); }},
             {}, &revocations),
        tls(std::move(door)),
        listener(io, hub, tls ? Entrance{&*tls, &gate} : Entrance{}, o.config.limits),
        view(io, hub, worker, *store, notes, o.config.merge,
             {o.config.keep == KeepClouds::newest, static_cast<std::uint64_t>(o.config.free_mib) * mib},
             [this] { return membership->servers(); }),
        room(view) {}
  ~Parts() { stop(); }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  Result<void> start();
  Result<void> choose_operator_tls();
  void stop();

  const ServerOptions options;
  std::unique_ptr<Membership> membership;
  RevocationLog revocations;
  boost::asio::io_context io;
  std::unique_ptr<Store> store;
  std::unique_ptr<PairHelpers> helpers;  // null: there can be none
  MergeWorker worker;
  SessionHub hub;
  StationNotes notes;
  RobotGate gate;
  std::optional<boost::asio::ssl::context> tls;  // none: --insecure
  RobotListener listener;
  StationView view;
  std::optional<RoomWatch> room;
  std::optional<RobotDesk> desk;
  std::unique_ptr<OperatorRegistry> people;            // null: --insecure
  std::optional<boost::asio::ssl::context> given_tls;  // for operators; none: the robots' serves them too
  bool https = false;
  std::optional<OperatorApi> api;
  Endpoint robots, http;
  std::string fingerprint;  // 32 bytes; empty: --insecure
  std::vector<std::thread> threads;
};

Result<void> MapMergeServer::Parts::start() {
  auto done = hub.restore();
  if (done) done = worker.restore();
  if (done) done = gate.restore();
  if (done) done = notes.restore();
  if (!done) return done;
  hub.set_uplink_budget(static_cast<std::uint64_t>(options.config.limits.uplink_kib_s) * 1024);
  auto token = options.insecure ? Result<std::string>("") : operator_token(options.data);
  if (!token) return tl::unexpected(token.error());
  listener.believe_relays(relay_key(*token));
  auto listening = listener.listen(membership->listen());
  if (!listening) return tl::unexpected(listening.error());
  robots = *listening;
  if (!options.insecure) desk.emplace(gate, fingerprint, to_string(options.config.public_address.value_or(robots)));
  if (!options.insecure) {
    auto known = OperatorRegistry::open(options.data / "operators.json");
    if (!known) return tl::unexpected(known.error());
    people = std::move(*known);
  }
  const std::filesystem::path log = options.data / "events.jsonl";
  if (!std::ofstream(log, std::ios::app))
    spdlog::warn("{} can not be written: what happens and what operators do is kept in memory alone", log.string());
  if (done = choose_operator_tls(); !done) return done;
  api.emplace(io, view, OperatorLimits{},
              OperatorAccess{*token, desk ? &*desk : nullptr, log, options.data / "notes.jsonl", people.get(),
                             https ? &*(given_tls ? given_tls : tls) : nullptr});
  done = api->listen(options.http.host, membership->http().port);
  if (!done) return done;
  http = {options.http.host, api->port()};
  membership->serves(robots, http, fingerprint, *token);
  worker.start(hub);
  room->start(view.keep_policy());
  for (int i = 0; i < options.config.io_threads; ++i) threads.emplace_back([this] { io.run(); });
  return {};
}

/// Plain HTTP is for the loopback, and for who asks for it.
Result<void> MapMergeServer::Parts::choose_operator_tls() {
  const OperatorConfig& wanted = options.config.operators;
  https = wanted.tls == OperatorTls::always || !wanted.certificate.empty() ||
          (wanted.tls == OperatorTls::beyond_loopback && !is_loopback(options.http) && !options.insecure);
  if (https && options.insecure)
    return failure(ErrorCode::invalid_argument,
                   "--insecure serves operators without TLS, and [operator] asks for it: leave one of them away");
  if (wanted.certificate.empty()) return {};
  auto given = given_identity(wanted.certificate, wanted.key);
  if (!given) return failure(given.error().code, "[operator]: " + given.error().message);
  given_tls = std::move(given->tls);
  return {};
}

void MapMergeServer::Parts::stop() {
  room.reset();
  listener.stop();
  if (api) api->stop();
  io.stop();  // what is left are waits of operators that have gone; robots repeat what was not acknowledged
  for (std::thread& thread : threads) thread.join();
  threads.clear();
  worker.stop();
  hub.stop_answers();
  store.reset();  // writes what was received; its callbacks find hub and worker still there
}

MapMergeServer::MapMergeServer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
MapMergeServer::~MapMergeServer() = default;

namespace {

Result<std::unique_ptr<Store>> open_store(const ServerOptions& options, Membership& membership) {
  const ServerConfig& config = options.config;
  const std::size_t queue_bytes = static_cast<std::size_t>(config.write_queue_mib) * mib;
  if (config.store_url.empty())
    return open_sqlite_store(options.data, {.queue_bytes = queue_bytes,
                                            .database_bytes = static_cast<std::uint64_t>(config.database_mib) * mib});
  return open_postgres_store(options.data, config.store_url,
                             {.queue_bytes = queue_bytes,
                              .clouds_bytes = static_cast<std::uint64_t>(config.clouds_mib) * mib,
                              .retry_ms = 100,
                              .longest_retry_ms = 2000},
                             membership.opening());
}

}  // namespace

Result<std::unique_ptr<MapMergeServer>> MapMergeServer::start(const ServerOptions& options) {
  google::protobuf::SetLogHandler(nullptr);  // it has a line for every bad string of every stranger
  auto membership = std::make_unique<Membership>(options);
  if (auto reserved = membership->reserve_ports(); !reserved) return tl::unexpected(reserved.error());
  auto store = open_store(options, *membership);
  if (!store) return tl::unexpected(store.error());
  membership->end_standby();
  std::optional<boost::asio::ssl::context> tls;
  std::string fingerprint;
  if (!options.insecure) {
    const auto robots = (*store)->robots();
    if (!robots) return tl::unexpected(robots.error());
    const bool known = std::any_of(robots->begin(), robots->end(), [](const auto& r) { return r.enrolled_s > 0; });
    auto identity = server_identity(options.data, !known || options.new_identity);
    if (!identity) return tl::unexpected(identity.error());
    fingerprint = identity->fingerprint;
    tls = std::move(identity->tls);
  }
  auto mark = WorkMark::open(options.data / "merging");
  if (!mark) return tl::unexpected(mark.error());
  auto revocations = RevocationLog::open(options.data / "revoked");
  if (!revocations) return tl::unexpected(revocations.error());
  auto parts = std::make_unique<Parts>(options, std::move(membership), std::move(*store), std::move(tls),
                                       std::move(*mark), std::move(*revocations));
  parts->fingerprint = fingerprint;
  if (auto done = parts->start(); !done) return tl::unexpected(done.error());
  return std::unique_ptr<MapMergeServer>(new MapMergeServer(std::move(parts)));
}

const Endpoint& MapMergeServer::robots() const { return parts_->robots; }
const std::string& MapMergeServer::fingerprint() const { return parts_->fingerprint; }
const Endpoint& MapMergeServer::http() const { return parts_->http; }
bool MapMergeServer::https() const { return parts_->https; }

}  // namespace headframe
