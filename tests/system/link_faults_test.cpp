// Robots and a server with a bad link between them: everything arrives exactly once.
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <future>

#include "client/uplink/uplink.hpp"
#include "server/map_merge_server.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/bench/link/audit.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/faulty_proxy.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe::bench {
namespace {

TEST(LinkFaults, CutAndStalledConnectionsLoseAndDoubleNothing) {
  constexpr std::uint64_t keyframes = 40;
  const test::ScratchFolder scratch;
  auto server = MapMergeServer::start({scratch.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}, true});
  ASSERT_TRUE(server) << server.error().message;
  const test::LinkFaults faults;
  const test::FaultyProxy proxy((*server)->robots().port, faults);
  std::map<std::string, std::unique_ptr<RobotClient>> robots;
  for (const std::string name : {"ant", "bee"}) {
    auto robot = RobotClient::open(drive_config(name, scratch.path() / name, "127.0.0.1", proxy.port()));
    ASSERT_TRUE(robot) << robot.error().message;
    robots[name] = std::move(*robot);
  }
  std::map<std::string, Produced> produced;
  std::map<std::string, Told> everything;
  for (std::uint64_t i = 1; i <= keyframes; ++i)
    for (auto& [name, robot] : robots) ASSERT_TRUE(add_drive_keyframe(*robot, name, i).value());
  for (auto& [name, robot] : robots) {
    const auto done = robot->finish(std::chrono::seconds(60));
    ASSERT_TRUE(done) << done.error().message;
    auto made = produce(name, keyframes, scratch.path() / "oracle" / name);
    ASSERT_TRUE(made);
    produced[name] = std::move(*made);
    Told& all = everything[name];
    all.keyframes = all.produced = keyframes;
    for (std::uint64_t s = 1; s <= keyframes; ++s) all.clouds.insert(s);
  }
  const auto found = audit(scratch.path() / "data", produced, everything);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->sum(), 0U) << found->first;
  EXPECT_EQ(found->keyframes, 2 * keyframes);
  EXPECT_GE(proxy.faults(), faults.cuts + faults.stalls);
}

TEST(LinkFaults, ConnectionsThatGetStuckHoldNoOtherBack) {
  const test::ScratchFolder scratch;
  auto server = MapMergeServer::start({scratch.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}});
  ASSERT_TRUE(server) << server.error().message;
  test::LinkFaults faults;
  faults.cuts = 0;
  faults.stalls = 3;  // in the middle of the TLS handshake, and for good
  faults.most_bytes = 10;
  const test::FaultyProxy proxy((*server)->robots().port, faults);
  UplinkConfig config;
  config.host = "127.0.0.1";
  config.port = proxy.port();
  config.fingerprint = (*server)->fingerprint();
  config.connect_s = 3600;
  config.connect_again_s = 0.01;
  std::promise<Error> answer;
  const Table nothing;
  Uplink uplink(config, rover(CloudPolicy::never), nothing, [&](const auto& event) {
    if (const auto* ended = std::get_if<LinkEnded>(&event)) answer.set_value(ended->error);
  });
  EXPECT_EQ(answer.get_future().get().code, ErrorCode::refused) << "the fourth got through, if only to be turned away";
  EXPECT_EQ(proxy.faults(), 3);
}

/// Keyframes that come while the uplink runs.
class Growing : public UplinkSource {
 public:
  std::atomic<std::uint64_t> keyframes{0};
  std::uint64_t last_sequence() const override { return keyframes; }
  Result<Keyframe> keyframe(std::uint64_t sequence) const override { return line_keyframe(sequence, 0.001); }
  bool holds_cloud(std::uint64_t) const override { return false; }
  std::uint64_t next_held_cloud(std::uint64_t) const override { return 0; }
  Result<std::string> cloud(std::uint64_t) const override { return failure(ErrorCode::bad_input, "none"); }
};

/// An uplink with spares over a proxy that can stall its connections.
class SparesOverAProxy : public testing::Test {
 protected:
  void SetUp() override {
    auto started = MapMergeServer::start({scratch_.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}, true});
    ASSERT_TRUE(started) << started.error().message;
    server_ = std::move(*started);
    test::LinkFaults none;
    none.cuts = none.stalls = 0;
    proxy_.emplace(server_->robots().port, none);
    UplinkConfig config;
    config.host = "127.0.0.1";
    config.port = proxy_->port();
    config.spares_from_loss = 0;
    config.limits.doubt_s = 0.2;
    Hello hello = robot_hello();
    hello.spool_runs = {10};
    uplink_.emplace(config, hello, source_, [this](const auto& event) {
      const std::lock_guard lock(mutex_);
      if (const auto* k = std::get_if<KeyframesDurable>(&event)) durable_ = std::max(durable_, k->up_to);
      welcomed_ += std::holds_alternative<Welcomed>(event);
      ended_ += std::holds_alternative<LinkEnded>(event);
      changed_.notify_all();
    });
  }

  bool becomes_durable(std::uint64_t up_to) {
    source_.keyframes = up_to;
    uplink_->wake();
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(30), [&] { return durable_ >= up_to; });
  }

  const test::ScratchFolder scratch_;
  Growing source_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t durable_ = 0;
  int welcomed_ = 0, ended_ = 0;
  std::unique_ptr<MapMergeServer> server_;
  std::optional<test::FaultyProxy> proxy_;
  std::optional<Uplink> uplink_;
};

TEST_F(SparesOverAProxy, OneTakesOverWhenTheLinkFallsSilent) {
  for (std::uint64_t k = 1; proxy_->connections() < 8; ++k) ASSERT_TRUE(becomes_durable(k));
  proxy_->stall(0);
  const std::uint64_t before = source_.keyframes;
  EXPECT_TRUE(becomes_durable(before + 5));
  EXPECT_TRUE(becomes_durable(before + 200)) << "more than fit a window: it carries the session now";
  EXPECT_EQ(welcomed_, 1);
  EXPECT_EQ(ended_, 0) << "nobody noticed";
}

TEST_F(SparesOverAProxy, AllMayDieAndEverythingArrivesOnce) {
  std::uint64_t k = 0;
  for (int dead = 0; dead < 12; ++dead) {  // more than stand at a time
    while (proxy_->connections() <= dead) ASSERT_TRUE(becomes_durable(++k));
    proxy_->stall(dead);
    ASSERT_TRUE(becomes_durable(k += 20)) << "after " << dead << " were dead";
  }
  uplink_->close(true);
  server_.reset();
  const auto store = open_sqlite_store(scratch_.path() / "data");
  ASSERT_TRUE(store) << store.error().message;
  std::uint64_t stored = 0;
  ASSERT_TRUE((*store)->each_keyframe(1, 1, [&](const Keyframe& kept) {
    EXPECT_EQ(kept.sequence, ++stored);
    EXPECT_EQ(kept.stamp_s, line_keyframe(stored, 0.001).stamp_s);
  }));
  EXPECT_EQ(stored, k);
}

}  // namespace
}  // namespace headframe::bench
