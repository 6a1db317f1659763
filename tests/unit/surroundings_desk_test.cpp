// Who asks what others know is answered from a real store, one answer at a time.
#include "server/net/surroundings_desk.hpp"

#include <array>
#include <condition_variable>
#include <deque>

#include "client/uplink/surroundings_book.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/protocol_fixture.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;
using Kind = SurroundingsKind;

/// Session 1 asks, session 2 has driven 300 m beside it. Between both stand the bytes of the protocol.
class Desk : public Protocol {
 protected:
  void SetUp() override {
    greet();
    for (const SessionId id : {1, 2}) put(PutSession{session_record(id, id == 1 ? "ant" : "bee")});
    drive(2, 1, 300);
  }
  void TearDown() override { desk_.stop(); }

  void put(Write write) { ASSERT_TRUE(write_and_wait(*store_, std::move(write))); }
  void drive(SessionId session, std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t s = first; s <= last; ++s) {
      Keyframe k = line_keyframe(s, step_m_);
      k.walls.code.fill(120);
      if (s < last)
        store_->write(PutKeyframe{session, k}, [](const Result<void>& done) { ASSERT_TRUE(done); });
      else
        put(PutKeyframe{session, k});
    }
    const std::lock_guard lock(mutex_);
    around_.durable[session] = last;
  }
  void merge() {
    const std::lock_guard lock(mutex_);
    around_.revision = 5;
    around_.component = {1, {{1, Pose::Identity()}, {2, pose_from_yaw(0, {0, 10, 0})}}};
    around_.keys = {{1, {"ant", "s1"}}, {2, {"bee", "s1"}}};
  }

  void ask(const v1::RobotMessage& message) {
    for (const RobotEvent& event : feed(frame(message))) {
      if (const auto* asked = std::get_if<SurroundingsAsked>(&event)) desk_.ask(1, *asked);
      if (const auto* asked = std::get_if<MapAsked>(&event)) desk_.ask(1, *asked);
      if (const auto* asked = std::get_if<MapNextAsked>(&event)) desk_.ask(1, *asked);
    }
  }
  /// The next answer, as it comes out of the server's side of the protocol.
  v1::ServerMessage answer() {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(told_any_.wait_for(lock, 30s, [&] { return !told_.empty(); }));
    if (told_.empty()) return {};
    protocol.tell_surroundings(told_.front().first, told_.front().second);
    told_.pop_front();
    const auto sent = messages(protocol.take_output());
    EXPECT_EQ(sent.size(), 1U);
    return sent.empty() ? v1::ServerMessage() : sent[0];
  }
  /// Takes answers in, and asks on, until one is whole.
  SurroundingsBook::Told whole_answer() {
    for (int i = 0; i < 1000; ++i) {
      auto taken = book_.take(answer());
      EXPECT_TRUE(taken) << taken.error().message;
      if (!taken) return {};
      if (taken->next) ask(*taken->next);
      if (taken->told.index() != 0) return taken->told;
    }
    ADD_FAILURE() << "it never ends";
    return {};
  }
  std::size_t told() {
    const std::lock_guard lock(mutex_);
    return told_.size();
  }

  double step_m_ = 1;
  TempDir dir_;
  std::unique_ptr<Store> store_ = open(dir_);
  std::mutex mutex_;
  std::condition_variable told_any_;
  SessionSurroundings around_;
  std::deque<std::pair<Kind, SurroundingsDesk::Payload>> told_;
  std::atomic<std::chrono::steady_clock::duration> time_{1h};
  SurroundingsBook book_;
  SurroundingsDesk desk_{*store_, 1ULL << 63,
                         [this](SessionId receiver) {
                           const std::lock_guard lock(mutex_);
                           around_.receiver = receiver;
                           return around_;
                         },
                         [this](SessionId, Kind kind, SurroundingsDesk::Payload payload) {
                           const std::lock_guard lock(mutex_);
                           told_.emplace_back(kind, std::move(payload));
                           told_any_.notify_all();
                         },
                         [this] { return SurroundingsDesk::Clock::time_point(time_.load()); }};
};

/// Session 2 has driven 9 km: several pages.
class LongDesk : public Desk {
 protected:
  LongDesk() { step_m_ = 30; }
};

TEST_F(Desk, WhoIsMergedWithNobodyIsToldSoOnceAndHearsWhenItIs) {
  book_.want_trajectories(true);
  ask(book_.trajectories_question());
  const auto nothing = std::get<Trajectories>(whole_answer());
  EXPECT_EQ(nothing.state, SurroundingsTold::State::none);
  EXPECT_NE(nothing.missing.find("merged with no other"), std::string::npos);
  merge();
  desk_.changed();
  time_ = 1h + 2s;
  desk_.look(1, 0);
  const auto paths = std::get<Trajectories>(whole_answer());
  EXPECT_EQ(paths.state, SurroundingsTold::State::told);
  EXPECT_EQ(paths.revision, 5U);
  ASSERT_EQ(paths.paths.size(), 1U);
  EXPECT_EQ(paths.paths[0].session.robot, "bee");
  EXPECT_EQ(paths.paths[0].p_local_m.size(), 150U);
  EXPECT_NEAR((paths.paths[0].p_local_m[0] - Eigen::Vector3d(1, 10.5, -0.25)).norm(), 0, 0.1);
}

TEST_F(Desk, AnUpdateIsToldWhenThereIsOneAndIsSmall) {
  merge();
  book_.want_coverage(true);
  ask(book_.coverage_question());
  const auto before = std::get<Coverage>(whole_answer());
  EXPECT_TRUE(before.at({250, 10.5, 0}).what & coverage_path);
  EXPECT_EQ(before.at({349, 10.5, 0}).what, 0);
  drive(2, 301, 350);
  desk_.changed();
  time_ = 1h + 2s;
  desk_.look(1, 0);
  const v1::ServerMessage update = answer();
  EXPECT_FALSE(update.coverage().page().anew());
  EXPECT_LT(update.ByteSizeLong(), 5000U);
  const auto taken = book_.take(update);
  ASSERT_TRUE(taken);
  const auto& after = std::get<Coverage>(taken->told);
  EXPECT_TRUE(after.at({349, 10.5, 0}).what & coverage_path);
  EXPECT_TRUE(after.at({250, 10.5, 0}).what & coverage_path) << "what was told before stays";
  EXPECT_EQ(after.sessions.at(2).robot, "bee");
}

TEST_F(LongDesk, OneAnswerIsOnItsWayUntilTheRobotAsksOn) {
  merge();
  book_.want_coverage(true);
  book_.want_trajectories(true);
  ask(book_.coverage_question());
  const v1::ServerMessage first = answer();
  ASSERT_TRUE(first.has_coverage());
  ASSERT_TRUE(first.coverage().page().more());
  desk_.look(1, 0);
  EXPECT_EQ(told(), 0U);
  ask(book_.take(first)->next.value());
  EXPECT_TRUE(answer().has_coverage());
  // Who does not ask on is told another thing after a while.
  time_ = 1h + 4900ms;
  v1::RobotMessage map;
  map.mutable_map_request()->set_id(1);
  desk_.look(1, 0);
  EXPECT_EQ(told(), 0U);
  ask(book_.trajectories_question());
  EXPECT_TRUE(answer().has_trajectories());
}

TEST_F(LongDesk, ARobotWithALimitIsToldNoFasterThanThat) {
  merge();
  book_.want_coverage(true);
  ask(book_.coverage_question());
  const v1::ServerMessage unlimited = answer();
  desk_.look(1, 1000);
  ask(book_.take(unlimited)->next.value());
  const v1::ServerMessage page = answer();
  const auto after_s = static_cast<double>(page.ByteSizeLong()) / 1000;
  ask(book_.take(page)->next.value());
  const auto at = [&](double s) {
    time_ = 1h + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
    desk_.look(1, 1000);
  };
  at(after_s - 0.2);
  EXPECT_EQ(told(), 0U);
  at(after_s + 0.2);
  EXPECT_TRUE(answer().has_coverage());
}

TEST_F(LongDesk, PagesGrowOverAQuickLinkAndShrinkOverASlowOne) {
  merge();
  book_.want_coverage(true);
  ask(book_.coverage_question());
  std::vector<std::size_t> bytes;
  const auto page_after = [&](std::chrono::steady_clock::duration took) {
    const v1::ServerMessage page = answer();
    bytes.push_back(page.ByteSizeLong());
    time_ = time_.load() + took;
    const auto taken = book_.take(page);
    ASSERT_TRUE(taken && taken->next);
    ask(*taken->next);
  };
  page_after(49ms);
  page_after(49ms);
  page_after(100ms);
  page_after(201ms);
  page_after(201ms);
  page_after(201ms);
  page_after(0ms);
  ASSERT_EQ(bytes.size(), 7U);
  constexpr std::size_t a_tile = 400;
  const std::array<std::size_t, 7> about{1024, 2048, 4096, 4096, 2048, 1024, 1024};
  for (std::size_t i = 0; i < about.size(); ++i) {
    EXPECT_GT(bytes[i] + a_tile, about[i]) << i;
    EXPECT_LT(bytes[i], about[i] + a_tile) << i;
  }
}

TEST_F(Desk, AMapComesInPartsAndIsWhatTheCloudsHold) {
  merge();
  KeyframeCloud cloud{{Sweep{}}};
  for (int i = 0; i < 20000; ++i)
    cloud.sweeps[0].points.emplace_back(0.001F * static_cast<float>(i * 37 % 6007),
                                        0.001F * static_cast<float>(i * 91 % 5003),
                                        0.001F * static_cast<float>(i * 53 % 2999));
  put(PutCloud{{2, 10}, encode_cloud(cloud).value()});
  book_.want_map({SphereRegion{{10, 11, 0}, 8}, 0.2});
  ask(book_.map_question());
  const auto map = std::get<MapAround>(whole_answer());
  EXPECT_EQ(map.refused, "");
  EXPECT_EQ(map.clouds, 1U);
  EXPECT_GT(map.points.size(), 5000U);
  EXPECT_EQ(map.origin_local_m, Eigen::Vector3d(10, 11, 0));
  // Since then: nothing, until a cloud comes.
  book_.want_map({SphereRegion{{10, 11, 0}, 8}, 0.2, map.held});
  ask(book_.map_question());
  const auto nothing = std::get<MapAround>(whole_answer());
  EXPECT_TRUE(nothing.since);
  EXPECT_TRUE(nothing.points.empty());
  put(PutCloud{{2, 11}, encode_cloud(cloud).value()});
  book_.want_map({SphereRegion{{10, 11, 0}, 8}, 0.2, nothing.held});
  ask(book_.map_question());
  EXPECT_EQ(std::get<MapAround>(whole_answer()).clouds, 1U) << "the new one alone";
}

TEST_F(Desk, AMapThatIsTooMuchIsRefusedAndSoIsOneOfNobodyElse) {
  book_.want_map({SphereRegion{{0, 0, 0}, 8}, 0.2});
  ask(book_.map_question());
  EXPECT_NE(std::get<MapAround>(whole_answer()).refused.find("merged with no other"), std::string::npos);
  merge();
  book_.want_map({SphereRegion{{0, 0, 0}, 800}, 0.2});
  ask(book_.map_question());
  EXPECT_NE(std::get<MapAround>(whole_answer()).refused.find("200 m"), std::string::npos);
  v1::RobotMessage shapeless;
  shapeless.mutable_map_request()->set_resolution_m(0.2F);
  ask(shapeless);
  EXPECT_NE(answer().map_part().refused(), "");
  EXPECT_FALSE(protocol.ended()) << "a refusal is no fault";
}

TEST_F(Desk, WhoLeftIsToldNothingAndStopEndsIt) {
  merge();
  book_.want_coverage(true);
  ask(book_.coverage_question());
  (void)answer();
  desk_.left(1);
  desk_.changed();
  time_ = 2h;
  desk_.look(1, 0);
  EXPECT_EQ(told(), 0U);
  desk_.stop();
  ask(book_.coverage_question());
  EXPECT_EQ(told(), 0U);
}

}  // namespace
}  // namespace headframe
