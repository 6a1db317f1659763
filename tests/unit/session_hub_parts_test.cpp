// A session whose odometry jumped goes on as another one, and its robot as if nothing were.
#include <numeric>
#include <random>

#include "common/wire/limits.hpp"
#include "server/net/session_hub.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/nobodys_news.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

using Numbers = std::vector<std::uint64_t>;

class RobotEnd : public RobotLink {
 public:
  Numbers keyframes, clouds, refused, asked;
  std::vector<v1::TransformUpdate> updates;
  bool stored = true, closed = false;
  void settled(std::size_t, const Result<void>& result) override { stored &= result.has_value(); }
  void keyframes_durable(std::uint64_t sequence) override { keyframes.push_back(sequence); }
  void cloud_durable(std::uint64_t sequence) override { clouds.push_back(sequence); }
  void cloud_refused(std::uint64_t sequence, const std::string&) override { refused.push_back(sequence); }
  void request_submap(const Numbers& sequences) override { asked = sequences; }
  void update_transform(std::shared_ptr<const TransformPages> all) override {
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(all->front()));
    updates.push_back(message.transform_update());
  }
  v1::Localization localization;  // the last
  void tell_localization(std::shared_ptr<const std::string> payload) override {
    v1::ServerMessage message;
    ASSERT_TRUE(message.ParseFromString(*payload));
    localization = message.localization();
  }
  void tell_surroundings(SurroundingsKind, std::shared_ptr<const std::string>) override {}
  void stand_by() override {}
  void close(v1::ErrorKind, const std::string&, bool) override { closed = true; }
};

/// What the worker was told, in words.
class HeardNews : public NobodysNews {
 public:
  std::mutex mutex;
  std::vector<std::string> heard;
  void say(const std::string& what, SessionId session, std::uint64_t number = 0) {
    const std::lock_guard lock(mutex);
    heard.push_back(what + " " + std::to_string(session) + (number > 0 ? "/" + std::to_string(number) : ""));
  }
  void session_added(SessionId session, const std::string&, const FamilyId&) override { say("added", session); }
  void keyframes_durable(SessionId session, std::uint64_t sequence) override { say("keyframe", session, sequence); }
  void cloud_durable(const KeyframeRef& cloud) override { say("cloud", cloud.session, cloud.sequence); }
  void clouds_unavailable(SessionId session, const Numbers& sequences) override {
    for (const std::uint64_t sequence : sequences) say("no cloud", session, sequence);
  }
  void robot_came(SessionId session, bool) override { say("came", session); }
  void robot_left(SessionId session) override { say("left", session); }
  void asks_where(SessionId session, bool asks) override { say(asks ? "asks" : "asks no more", session); }
  void trigger(SessionId session, Trigger trigger) override {
    say(trigger == Trigger::goodbye ? "ended" : "trigger", session);
  }
  bool has(const std::string& what) {
    const std::lock_guard lock(mutex);
    return std::find(heard.begin(), heard.end(), what) != heard.end();
  }
};

class HubParts : public testing::Test {
 protected:
  void SetUp() override { start(); }
  void TearDown() override { store_.reset(); }  // its callbacks find the hub

  void start() {
    store_.reset();
    hub_.reset();
    store_ = open(dir_);
    hub_ = std::make_unique<SessionHub>(*store_, news_);
    ASSERT_TRUE(hub_->restore());
    come();
  }
  Hello hello(std::uint64_t run = 10) const {
    Hello h = robot_hello();
    h.spool_runs = {run};
    return h;
  }
  void come() {
    link_ = std::make_shared<RobotEnd>();
    const auto admitted = hub_->admit(hello(), link_);
    ASSERT_TRUE(admitted) << admitted.error().message;
    id_ = admitted->session;
    durable_ = admitted->durable;
    settle();
  }
  void settle() const {
    while (hub_->unsettled() > 0) std::this_thread::yield();
  }
  void keyframes(std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t i = first; i <= last; ++i) hub_->take(id_, KeyframeReceived{line_keyframe(i)}, link_);
    settle();
  }
  void cloud(std::uint64_t sequence) {
    hub_->take(id_, CloudReceived{sequence, "cloud " + std::to_string(sequence)}, link_);
    settle();
  }
  void cut(SessionId session, std::uint64_t from, bool for_good = true) {
    hub_->tell_cut(session, {from, for_good, "its odometry jumps 400 m"});
    settle();
  }
  SessionRow row(SessionId session) const {
    for (const SessionRow& row : hub_->sessions())
      if (row.id == session) return row;
    return {};
  }
  /// The robot's numbers of what a session has, by where its keyframes lie.
  Numbers stored(SessionId session) const {
    Numbers out;
    for (const Keyframe& k : headframe::keyframes(*store_, session))
      out.push_back(static_cast<std::uint64_t>(std::llround(k.T_local_sensor.translation().x())));
    return out;
  }

  TempDir dir_;
  HeardNews news_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<SessionHub> hub_;
  std::shared_ptr<RobotEnd> link_;
  SessionId id_ = 0;
  Durable durable_;
};

TEST_F(HubParts, WhatFollowsAJumpIsASessionOfItsOwnAndTheRobotGoesOn) {
  keyframes(1, 7);
  for (const std::uint64_t i : {2, 5}) cloud(i);
  cut(1, 4);
  EXPECT_EQ(stored(1), (Numbers{1, 2, 3}));
  EXPECT_EQ(stored(2), (Numbers{4, 5, 6, 7}));
  EXPECT_EQ(store_->cloud({1, 2}).value(), "cloud 2");
  EXPECT_EQ(store_->cloud({2, 2}).value(), "cloud 5");
  EXPECT_FALSE(store_->cloud({1, 5}));
  for (const char* told : {"added 2", "came 2", "ended 1", "keyframe 2/4", "cloud 2/2"})
    EXPECT_TRUE(news_.has(told)) << told;
  keyframes(8, 8);
  for (const std::uint64_t i : {3, 8}) cloud(i);
  EXPECT_EQ(stored(1), (Numbers{1, 2, 3}));
  EXPECT_EQ(stored(2), (Numbers{4, 5, 6, 7, 8}));
  EXPECT_EQ(store_->cloud({1, 3}).value(), "cloud 3") << "of the time before the jump";
  EXPECT_EQ(store_->cloud({2, 5}).value(), "cloud 8");
  EXPECT_EQ(link_->keyframes, (Numbers{1, 2, 3, 4, 5, 6, 7, 8})) << "acknowledged by its own numbers";
  EXPECT_EQ(link_->clouds, (Numbers{2, 5, 3, 8}));
  EXPECT_TRUE(link_->stored);
  EXPECT_EQ(hub_->keys().at(2).session, "s1~4");
  EXPECT_FALSE(row(1).connected);
  EXPECT_TRUE(row(1).complete);
  EXPECT_TRUE(row(2).connected);
  EXPECT_EQ(row(1).why_cut,
            "from keyframe 4 on it is session s1~4, which is merged for itself: its odometry jumps 400 m");
  EXPECT_EQ(row(2).why_cut, "");
  EXPECT_EQ(hub_->policy_of(id_).cut, row(1).why_cut) << "the robot is told";
  for (const bool restarted : {false, true}) {
    restarted ? start() : come();
    EXPECT_EQ(id_, 1);
    EXPECT_EQ(durable_.keyframes, 8U) << restarted;
    EXPECT_EQ(durable_.clouds, (Numbers{2, 3, 5, 8}));
    EXPECT_EQ(hub_->durable_keyframes(id_), 8U);
  }
  EXPECT_NE(hub_->policy_of(id_).cut.find("from keyframe 4 on it is session s1~4"), std::string::npos);
  keyframes(7, 9);  // what it was not sure of is repeated
  EXPECT_EQ(stored(2), (Numbers{4, 5, 6, 7, 8, 9}));
  EXPECT_TRUE(link_->stored);
}

TEST_F(HubParts, CloudsOfEachPartAreAskedOfTheRobotByItsNumbers) {
  keyframes(1, 7);
  cut(1, 4);
  hub_->request_submap(1, {1, 3});
  EXPECT_EQ(link_->asked, (Numbers{1, 3}));
  hub_->request_submap(2, {1, 3});
  EXPECT_EQ(link_->asked, (Numbers{4, 6}));
  hub_->take(id_, CloudsUnavailable{{3, 6}}, link_);
  EXPECT_TRUE(news_.has("no cloud 1/3") && news_.has("no cloud 2/3"));
  hub_->take(id_, CloudRefused{7, "it does not decode"}, link_);
  EXPECT_TRUE(news_.has("no cloud 2/4"));
  hub_->left(id_, link_.get());
  EXPECT_TRUE(news_.has("left 1") && news_.has("left 2"));
  hub_->request_submap(2, {2});
  EXPECT_TRUE(news_.has("no cloud 2/2")) << "nobody is there to ask";
}

TEST_F(HubParts, EachFurtherJumpBeginsAnotherPartUpToABound) {
  keyframes(1, 5);
  cut(1, 3);
  keyframes(6, 8);
  cut(2, 4);  // the robot's sixth
  EXPECT_EQ(hub_->keys().at(3).session, "s1~6");
  EXPECT_EQ(stored(2), (Numbers{3, 4, 5}));
  EXPECT_EQ(stored(3), (Numbers{6, 7, 8}));
  start();
  EXPECT_EQ(durable_.keyframes, 8U);
  cut(2, 4);
  EXPECT_EQ(hub_->keys().size(), 3U) << "said again of what was split before";
  for (std::uint64_t next = 9; next < 30; next += 2) {
    keyframes(next, next + 1);
    cut(static_cast<SessionId>(hub_->keys().rbegin()->first), 3 - (next == 9 ? 0 : 1));
  }
  EXPECT_EQ(hub_->keys().size(), 1 + SessionHub::most_parts);
  EXPECT_TRUE(link_->stored);
  EXPECT_NE(hub_->policy_of(id_).cut.find("is left out of merging"), std::string::npos);
  EXPECT_NE(hub_->policy_of(id_).cut.find("begin a new session"), std::string::npos);
  start();
  EXPECT_EQ(durable_.keyframes, 30U);
}

TEST_F(HubParts, PartsCountAmongTheSessionsThatARobotMayBegin) {
  RobotLimits limits;
  limits.sessions_a_day = 2;
  hub_ = std::make_unique<SessionHub>(*store_, news_, limits);
  come();
  keyframes(1, 5);
  cut(1, 3);
  keyframes(6, 8);
  cut(2, 4);
  EXPECT_EQ(hub_->keys().size(), 2U);
  EXPECT_NE(hub_->policy_of(id_).cut.find("from keyframe 6 on it is left out of merging"), std::string::npos);
}

/// Whatever the robot sends, wherever its odometry jumps, and whenever the link or the server goes away.
TEST_F(HubParts, EachKeyframeAndCloudIsStoredOnceInOrderWhateverHappens) {
  std::mt19937 random(5);
  const auto below = [&](std::uint64_t n) { return random() % n; };
  std::uint64_t sent = 0;
  std::set<std::uint64_t> clouds;
  for (int step = 0; step < 120; ++step) {
    const std::uint64_t choice = below(10), last = static_cast<std::uint64_t>(hub_->keys().rbegin()->first);
    if (choice < 4) {
      const std::uint64_t more = 1 + below(5), again = below(std::min<std::uint64_t>(sent, 3) + 1);
      keyframes(sent + 1 - again, sent + more);
      sent += more;
    } else if (choice < 7 && sent > 0) {
      const std::uint64_t of = 1 + below(sent);
      cloud(of);
      clouds.insert(of);
    } else if (choice == 7 && row(static_cast<SessionId>(last)).keyframes > 1) {
      cut(static_cast<SessionId>(last), 2 + below(row(static_cast<SessionId>(last)).keyframes - 1));
    } else if (choice > 7) {
      choice == 8 ? come() : start();
      EXPECT_EQ(durable_.keyframes, sent);
      EXPECT_EQ(durable_.clouds, Numbers(clouds.begin(), clouds.end()));
    }
    ASSERT_TRUE(link_->stored) << step;
  }
  EXPECT_EQ(hub_->keys().size(), 1 + SessionHub::most_parts);
  Numbers all;
  std::set<std::uint64_t> found;
  for (const auto& [id, key] : hub_->keys()) {
    const Numbers part = stored(id);
    const Numbers stored_clouds = store_->cloud_sequences(id).value();
    for (const std::uint64_t sequence : stored_clouds) {
      EXPECT_EQ(store_->cloud({id, sequence}).value(), "cloud " + std::to_string(all.size() + sequence));
      found.insert(all.size() + sequence);
    }
    all.insert(all.end(), part.begin(), part.end());
  }
  Numbers expected(sent);
  std::iota(expected.begin(), expected.end(), 1);
  EXPECT_EQ(all, expected);
  EXPECT_EQ(found, clouds);
}

TEST_F(HubParts, ForThreeKeyframesItIsOnlySaid) {
  keyframes(1, 5);
  cut(1, 4, false);
  EXPECT_EQ(hub_->keys().size(), 1U);
  EXPECT_EQ(hub_->policy_of(id_).cut, "from keyframe 4 on it is left out of merging: its odometry jumps 400 m");
  hub_->tell_cut(1, {});
  EXPECT_EQ(hub_->policy_of(id_).cut, "");
}

TEST_F(HubParts, TheRobotIsToldTransformsOfThePartWhereItIsUnderItsOwnName) {
  const auto bee = std::make_shared<RobotEnd>();
  const SessionId other = hub_->admit(robot_hello("bee"), bee).value().session;
  const Pose T = pose_from_yaw(0.5, {1, 2, 3});
  Atlas atlas{1, {{1, {{1, Pose::Identity()}, {other, T}}}}};
  hub_->publish(atlas, atlas.components, {});
  keyframes(1, 7);
  cut(1, 4);
  const SessionId part = 3;
  ASSERT_EQ(link_->updates.size(), 2U) << "what it was told of before the jump means nothing any more";
  ASSERT_EQ(link_->updates[1].sessions_size(), 1);
  EXPECT_EQ(link_->updates[1].sessions(0).session().session(), "s1");
  atlas = {2, {{1, {{1, Pose::Identity()}, {other, T}, {part, T.inverse()}}}}};
  hub_->publish(atlas, atlas.components, {});
  const auto name = [](const v1::TransformUpdate& update, int i) {
    return update.sessions(i).session().robot() + "/" + update.sessions(i).session().session();
  };
  ASSERT_EQ(link_->updates.size(), 3U);
  const auto& told = link_->updates[2];
  ASSERT_EQ(told.sessions_size(), 3);
  EXPECT_EQ(name(told, 0), "ant/s1~1");
  EXPECT_EQ(name(told, 1), "bee/s1");
  EXPECT_EQ(name(told, 2), "ant/s1");
  EXPECT_EQ(told.anchor().session(), "s1~1");
  EXPECT_TRUE(from_proto(told.sessions(2).t_component_session())->isApprox(T.inverse(), 1e-9));
  ASSERT_EQ(bee->updates.size(), 2U);
  EXPECT_EQ(name(bee->updates[1], 0), "ant/s1") << "to others each session has its name";
  EXPECT_EQ(name(bee->updates[1], 2), "ant/s1~4");
  come();
  ASSERT_TRUE(hub_->admit(hello(), link_)->transform);
}

TEST_F(HubParts, WhoAsksWhereItIsIsAnsweredOfThePartByItsOwnNumbers) {
  keyframes(1, 7);
  hub_->take(id_, WhereAsked{true}, link_);
  settle();
  cut(1, 4);
  EXPECT_TRUE(news_.has("asks no more 1") && news_.has("asks 2"));
  SessionLocalization found{.found = true, .component = 1, .on = 1, .keyframe = 3};
  hub_->tell_localization(2, found);
  EXPECT_EQ(link_->localization.keyframe(), 6U);
  EXPECT_EQ(link_->localization.session().session(), "s1~1");
  hub_->take(id_, WhereAsked{false}, link_);
  settle();
  EXPECT_TRUE(news_.has("asks no more 2"));
}

TEST_F(HubParts, AGoodbyeEndsThePartAndADeletedPartItsRobot) {
  keyframes(1, 7);
  cut(1, 4);
  hub_->take(id_, GoodbyeReceived{true}, link_);
  settle();
  EXPECT_TRUE(news_.has("ended 2"));
  EXPECT_TRUE(store_->sessions()->at(1).complete);
  hub_->forget(2);
  EXPECT_TRUE(link_->closed);
  EXPECT_EQ(hub_->admit(hello(), link_).error().code, ErrorCode::refused);
}

TEST_F(HubParts, WhoCallsItsSessionsAsPartsAreCalledKeepsThemApart) {
  for (const auto& [name, keyframes] : std::map<std::string, std::uint64_t>{{"s9", 5}, {"s9~4", 2}}) {
    Hello own = hello();
    own.session.session = name;
    own.spool_id = 78;
    const auto link = std::make_shared<RobotEnd>();
    const SessionId id = hub_->admit(own, link).value().session;
    for (std::uint64_t i = 1; i <= keyframes; ++i) hub_->take(id, KeyframeReceived{line_keyframe(i)}, link);
    settle();
  }
  start();
  for (const auto& [name, keyframes] : std::map<std::string, std::uint64_t>{{"s9", 5}, {"s9~4", 2}}) {
    Hello own = hello();
    own.session.session = name;
    own.spool_id = 78;
    const auto admitted = hub_->admit(own, std::make_shared<RobotEnd>());
    ASSERT_TRUE(admitted) << admitted.error().message;
    EXPECT_EQ(admitted->durable.keyframes, keyframes) << name;
  }
}

TEST_F(HubParts, NamesOfPartsAreTheServersAndALongNameGetsNone) {
  keyframes(1, 7);
  cut(1, 4);
  Hello as_part = hello();
  as_part.session.session = "s1~4";
  const auto refused = hub_->admit(as_part, std::make_shared<RobotEnd>());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("ant/s1~4 was made by the server"), std::string::npos)
      << refused.error().message;
  Hello own = hello();
  own.session.session = "s9~4";
  own.spool_id = 78;
  ASSERT_TRUE(hub_->admit(own, std::make_shared<RobotEnd>())) << "a robot may call its session what it likes";
  Hello longest = hello();
  longest.session.session = std::string(limits::name_bytes - 1, 'x');
  longest.spool_id = 79;
  const auto link = std::make_shared<RobotEnd>();
  const SessionId id = hub_->admit(longest, link)->session;
  for (std::uint64_t i = 1; i <= 7; ++i) hub_->take(id, KeyframeReceived{line_keyframe(i)}, link);
  settle();
  const std::size_t sessions = hub_->keys().size();
  cut(id, 4);
  EXPECT_EQ(hub_->keys().size(), sessions);
  EXPECT_EQ(stored(id).size(), 7U);
}

}  // namespace
}  // namespace headframe
