#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>

#include "server/store/schema.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

TEST(Store, KeepsRobotsAsTheyWerePutLast) {
  const TempDir dir;
  const RobotRecord ant{"ant", std::string("\0digest\xff", 8), "", 12.5, 3, false, 64},
      bee{"bee", "", "code", 1, 0, true};
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutRobot{bee}));
    ASSERT_TRUE(write_and_wait(*store, PutRobot{{"ant", "old", "code", 1, 2, true}}));
    ASSERT_TRUE(write_and_wait(*store, PutRobot{ant}));
  }
  const auto robots = open(dir)->robots();
  ASSERT_TRUE(robots) << robots.error().message;
  EXPECT_EQ(*robots, (std::vector<RobotRecord>{ant, bee}));
}

TEST(Store, KeepsTheLastRunOfASpool) {
  const TempDir dir;
  SessionRecord session = session_record(1, "ant");
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutSession{session}));
    ASSERT_TRUE(write_and_wait(*store, CompleteSession{1}));
    session.spool_run = ~0ULL;  // all bits come back
    ASSERT_TRUE(write_and_wait(*store, PutSession{session}));
  }
  const auto sessions = open(dir)->sessions();
  ASSERT_EQ(sessions->size(), 1U);
  EXPECT_EQ(sessions->front().spool_run, ~0ULL);
  EXPECT_TRUE(sessions->front().complete) << "nothing else changes";
}

TEST(Store, KeepsSessionsKeyframesAndCloudsBitForBit) {
  const TempDir dir;
  const SessionRecord session = session_record(1, "ant");
  const Keyframe k = line_keyframe(1);
  const std::string encoded("\0cloud\xff", 7);
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutSession{session}));
    ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, k}));
    ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, 1}, encoded}));
    ASSERT_TRUE(write_and_wait(*store, CompleteSession{1}));
  }
  const auto store = open(dir);
  const auto sessions = store->sessions();
  ASSERT_TRUE(sessions);
  ASSERT_EQ(sessions->size(), 1U);
  const SessionRecord& s = sessions->front();
  EXPECT_EQ(s.key, session.key);
  EXPECT_EQ(s.family, session.family);
  EXPECT_EQ(s.sensor.beams, 32);
  EXPECT_EQ(s.spool_id, 77U);
  EXPECT_TRUE(s.complete);
  const auto all = keyframes(*store, 1);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].T_local_sensor.matrix(), k.T_local_sensor.matrix());
  EXPECT_EQ(all[0].descriptor.q, k.descriptor.q);
  EXPECT_EQ(all[0].descriptor.w, k.descriptor.w);
  EXPECT_EQ(all[0].descriptor.place_class, PlaceClass::tunnel);
  EXPECT_EQ(all[0].walls.code, k.walls.code);
  EXPECT_EQ(all[0].point_count, 1000U);
  EXPECT_EQ(store->cloud({1, 1}).value(), encoded);
  EXPECT_EQ(store->cloud_sequences(1).value(), std::vector<std::uint64_t>{1});
  EXPECT_EQ(store->cloud({1, 2}).error().code, ErrorCode::not_found);
}

TEST(Store, KeepsTheAtlasWithItsEvidence) {
  const TempDir dir;
  Alignment alignment{1, 1, 2, AlignmentState::published, pose_from_yaw(0.5, {1, 2, 3}), {}};
  alignment.evidence.probability = 0.97;
  alignment.evidence.slide_ratio = std::numeric_limits<double>::quiet_NaN();
  const Atlas atlas{4, {{1, {{1, Pose::Identity()}, {2, alignment.T_a_b}}}}};
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{2, 17, {alignment}, atlas, {}}));
    alignment.state = AlignmentState::retracted;
    ASSERT_TRUE(write_and_wait(*store, PutMerge{1, 9, {alignment}, std::nullopt, {}}));
  }
  const auto store = open(dir);
  const auto merge = store->merge();
  ASSERT_TRUE(merge);
  ASSERT_EQ(merge->alignments.size(), 1U);
  EXPECT_EQ(merge->alignments[0].state, AlignmentState::retracted);
  EXPECT_EQ(merge->alignments[0].T_a_b.matrix(), alignment.T_a_b.matrix());
  EXPECT_EQ(merge->alignments[0].evidence.probability, 0.97);
  EXPECT_TRUE(std::isnan(merge->alignments[0].evidence.slide_ratio));
  EXPECT_EQ(merge->atlas.revision, 4U);
  ASSERT_EQ(merge->atlas.components.size(), 1U);
  EXPECT_EQ(merge->atlas.components[0].placements[1].T_component_session.matrix(), alignment.T_a_b.matrix());
  EXPECT_EQ(store->sessions()->at(1).attempted_keyframes, 17U);
}

TEST(Store, KeepsDecisionsAndThatTheyWereUndone) {
  const TempDir dir;
  DecisionRecord refusal{1, 7, Decision::refuse, pose_from_yaw(0.5, {1, 2, 3}), 5000, false};
  const DecisionRecord confirmation{2, 8, Decision::confirm, Pose::Identity(), 10, false};
  {
    const auto store = open(dir);
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, std::nullopt, {refusal, confirmation}}));
    refusal.undone = true;
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, std::nullopt, {refusal}}));
  }
  const auto decisions = open(dir)->merge()->decisions;
  ASSERT_EQ(decisions.size(), 2U);
  EXPECT_TRUE(decisions[0].undone);
  EXPECT_EQ(decisions[0].decision, Decision::refuse);
  EXPECT_EQ(decisions[0].alignment, 7);
  EXPECT_EQ(decisions[0].T_a_b.matrix(), refusal.T_a_b.matrix());
  EXPECT_EQ(decisions[0].seen_points, 5000);
  EXPECT_FALSE(decisions[1].undone);
  EXPECT_EQ(decisions[1].decision, Decision::confirm);
}
Survey survey_of(SessionId session) {
  return {session,
          pose_from_yaw(0.5, {431250.123456789, 6212400.25, -3}),
          {{"P1", {1, 2, 3}, {431251.1, 6212402.2, 0}}, {"P \"2\"", {0.1, 0.2, 0.3}, {4, 5, 6}}}};
}

TEST(Store, KeepsLabelsAnchorsAndSurveys) {
  const TempDir dir;
  const Survey first = survey_of(1), second{2, Pose::Identity(), {}};
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    ASSERT_TRUE(write_and_wait(*store, PutLabel{1, "north drift"}));
    ASSERT_TRUE(write_and_wait(*store, PutLabel{2, "gone"}));
    ASSERT_TRUE(write_and_wait(*store, PutLabel{2, ""}));
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "robot1")})) << "the robot comes again";
    for (const SessionId id : {2, 1, 7, 2}) ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {}, {}, {}, id}));
    for (const Survey& survey : {first, second, survey_of(3), first})
      ASSERT_TRUE(write_and_wait(*store, PutSurvey{survey}));
    ASSERT_TRUE(write_and_wait(*store, DropSurvey{3}));
  }
  const auto store = open(dir);
  const auto notes = store->notes();
  ASSERT_TRUE(notes) << notes.error().message;
  EXPECT_EQ(notes->labels, (std::map<SessionId, std::string>{{1, "north drift"}}));
  EXPECT_EQ(store->merge()->anchors, (std::vector<SessionId>{1, 7, 2})) << "in the order of their last choice";
  ASSERT_EQ(notes->surveys.size(), 2U);
  EXPECT_EQ(notes->surveys[0].session, 2);
  EXPECT_TRUE(notes->surveys[0].points.empty());
  const Survey& last = notes->surveys[1];
  EXPECT_EQ(last.session, 1);
  EXPECT_EQ(last.T_grid_session.matrix(), first.T_grid_session.matrix());
  ASSERT_EQ(last.points.size(), 2U);
  EXPECT_EQ(last.points[1].name, "P \"2\"");
  EXPECT_EQ(last.points[1].p_session_m, first.points[1].p_session_m);
  EXPECT_EQ(last.points[0].p_grid_m, first.points[0].p_grid_m);
}

TEST(Store, KeepsTheRunnerUpsPlacement) {
  const TempDir dir;
  Alignment with{1, 1, 2, AlignmentState::candidate, Pose::Identity(), {}}, without = with;
  with.T_a_b_runner_up = pose_from_yaw(0.5, {1, 2, 3});
  without.id = 2, without.b = 3;
  {
    const auto store = open(dir);
    for (const SessionId id : {1, 2, 3})
      ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(id, "robot" + std::to_string(id))}));
    ASSERT_TRUE(write_and_wait(*store, PutMerge{0, 0, {with, without}, {}, {}}));
  }
  const auto merge = open(dir)->merge();
  ASSERT_EQ(merge->alignments.size(), 2U);
  ASSERT_TRUE(merge->alignments[0].T_a_b_runner_up);
  EXPECT_EQ(merge->alignments[0].T_a_b_runner_up->matrix(), with.T_a_b_runner_up->matrix());
  EXPECT_FALSE(merge->alignments[1].T_a_b_runner_up);
}

TEST(Store, RepeatsChangeNothingAndHolesFail) {
  const TempDir dir;
  const auto store = open(dir);
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  for (const std::uint64_t sequence : {1, 2, 1, 2, 3}) {
    ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(sequence)}));
    ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, sequence}, "first"}));
  }
  ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, 2}, "second"}));
  EXPECT_FALSE(write_and_wait(*store, PutKeyframe{1, line_keyframe(5)})) << "4 is missing";
  EXPECT_FALSE(write_and_wait(*store, PutCloud{{1, 9}, "no such keyframe"}));
  EXPECT_FALSE(store->load().last_error.empty());
  EXPECT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(4)})) << "one bad write fails alone";
  EXPECT_TRUE(store->load().last_error.empty());
  EXPECT_EQ(keyframes(*store, 1).size(), 4U);
  EXPECT_EQ(keyframes(*store, 1, 3).front().sequence, 3U);
  EXPECT_EQ(store->cloud({1, 2}).value(), "first");
}

TEST(Store, AnotherKeyframeOfTheSameNumberFails) {
  const std::vector<std::pair<std::string, std::function<void(Keyframe&)>>> changes{
      {"another stamp", [](Keyframe& k) { k.stamp_s += 1e-6; }},
      {"another pose", [](Keyframe& k) { k.T_local_sensor.translation().z() += 0.01; }},
      {"another descriptor", [](Keyframe& k) { k.descriptor.q.back() += 1; }},
      {"another descriptor", [](Keyframe& k) { k.descriptor.w.pop_back(); }},
      {"another descriptor", [](Keyframe& k) { k.descriptor.place_class = PlaceClass::junction; }},
      {"other walls", [](Keyframe& k) { k.walls.code.back() = 1; }},
      {"another scan", [](Keyframe& k) { k.point_count = 0; }},
      {"another scan", [](Keyframe& k) { k.spaciousness_m = 9; }}};
  const TempDir dir;
  const auto store = open(dir);
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(1)}));
  for (const auto& [what, change] : changes) {
    Keyframe other = line_keyframe(1);
    change(other);
    const auto refused = write_and_wait(*store, PutKeyframe{1, other});
    ASSERT_FALSE(refused) << what;
    EXPECT_EQ(refused.error().code, ErrorCode::refused);
    EXPECT_NE(refused.error().message.find("with " + what), std::string::npos) << refused.error().message;
  }
  EXPECT_EQ(keyframes(*store, 1).at(0).stamp_s, line_keyframe(1).stamp_s);
  Keyframe rounded = line_keyframe(1);  // as another compiler's arithmetic would have it
  rounded.T_local_sensor.linear()(0, 1) += 1e-15;
  EXPECT_TRUE(write_and_wait(*store, PutKeyframe{1, rounded}));
}

TEST(Store, WrongKeyframesDoNotSplitTheCommitThatTheyCameWith) {
  const TempDir dir;
  const auto store = open(dir, {.group_ms = 500});
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(2, "bee")}));
  const std::uint64_t commits = store->load().commits;
  std::atomic<int> wrong{0}, right{0};
  const auto count = [&](const Result<void>& done) { ++(done ? right : wrong); };
  Keyframe other = line_keyframe(1);
  other.stamp_s += 1;
  for (std::uint64_t i = 1; i <= 50; ++i) {
    store->write(PutKeyframe{1, line_keyframe(i)}, count);
    store->write(PutKeyframe{1, other}, count);              // of a number that is taken
    store->write(PutKeyframe{1, line_keyframe(99)}, count);  // leaves a hole
    store->write(PutCloud{{2, i}, "of no keyframe"}, count);
  }
  ASSERT_TRUE(write_and_wait(*store, PutKeyframe{2, line_keyframe(1)}));
  EXPECT_EQ(right, 50);
  EXPECT_EQ(wrong, 150);
  EXPECT_EQ(keyframes(*store, 1).size(), 50U);
  EXPECT_EQ(keyframes(*store, 2).size(), 1U);
  EXPECT_LE(store->load().commits - commits, 4U);
}

TEST(Store, NobodyElseReadsWhatIsInIt) {
  namespace fs = std::filesystem;
  const auto mode = [](const fs::path& path) { return fs::status(path).permissions(); };
  constexpr auto folder = fs::perms::owner_all, file = fs::perms::owner_read | fs::perms::owner_write;
  const TempDir dir;
  const fs::path data = dir.path() / "new" / "data", db = data / "headframe.db";
  for (const bool of_an_older_server : {false, true}) {
    if (of_an_older_server) {
      fs::permissions(data, fs::perms(0755));
      fs::permissions(db, fs::perms(0644));
      fs::permissions(data / "headframe.lock", fs::perms(0644));
    }
    const auto store = open_sqlite_store(data);
    ASSERT_TRUE(store);
    ASSERT_TRUE(write_and_wait(**store, PutSession{session_record(1, "ant")}));
    EXPECT_EQ(mode(data), folder);
    for (const char* name : {"headframe.db", "headframe.db-wal", "headframe.db-shm", "headframe.lock"})
      EXPECT_EQ(mode(data / name), file) << name;
  }
}

TEST(Store, ASecondServerIsKeptOutAlsoWithoutTheLockFile) {
  const TempDir dir;
  const auto first = open(dir);
  ASSERT_TRUE(std::filesystem::remove(dir.path() / "headframe.lock"));
  const auto second = open_sqlite_store(dir.path());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("in use by another"), std::string::npos) << second.error().message;
}

TEST(Store, AFolderWithOtherThingsInItStaysOpenToOthers) {
  namespace fs = std::filesystem;
  const TempDir home;
  fs::permissions(home.path(), fs::perms(0755));
  std::ofstream(home.path() / "letter.txt") << "dear";
  const auto store = open(home);
  EXPECT_EQ(fs::status(home.path()).permissions(), fs::perms(0755));
  EXPECT_EQ(fs::status(home.path() / "headframe.db").permissions(), fs::perms(0600));
}

TEST(Store, FullQueueRefusesAtOnce) {
  const TempDir dir;
  const auto store = open(dir, {.queue_bytes = 4096});
  EXPECT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  const auto refused = write_and_wait(*store, PutCloud{{1, 1}, std::string(4096, 'x')});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
  EXPECT_EQ(store->load().queued_bytes, 0U);
}

std::string open_error(const std::filesystem::path& path) {
  const auto store = open_sqlite_store(path);
  return store ? "opened" : store.error().message;
}

TEST(Store, BadDirectoriesGiveOneClearLine) {
  const TempDir dir;
  std::ofstream(dir.path() / "file") << "x";
  EXPECT_NE(open_error(dir.path() / "file").find("can not be created"), std::string::npos);
  EXPECT_NE(open_error("/proc/headframe").find("can not be created"), std::string::npos);
  std::filesystem::create_directory(dir.path() / "damaged");
  std::ofstream(dir.path() / "damaged" / "headframe.db") << std::string(100000, 'x');
  EXPECT_NE(open_error(dir.path() / "damaged").find("no headframe database"), std::string::npos);
  EXPECT_EQ(open_error(dir.path() / "made" / "twice"), "opened") << "what is not there is made";
}

TEST(Store, OneServerToADirectory) {
  const TempDir dir;
  const auto store = open(dir);
  EXPECT_NE(open_error(dir.path()).find("in use"), std::string::npos);
}

TEST(Store, NewerSchemaIsRefusedAndTheSameIsKept) {
  const TempDir dir;
  open(dir).reset();
  const auto set_version = [&](int version) {
    auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
    ASSERT_TRUE(database);
    ASSERT_TRUE(database->execute("PRAGMA user_version=" + std::to_string(version)));
  };
  set_version(schema_version() + 1);
  const auto refused = open_sqlite_store(dir.path());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::incompatible);
  EXPECT_NE(refused.error().message.find("newer headframe-server"), std::string::npos);
  set_version(schema_version());
  EXPECT_EQ(open_error(dir.path()), "opened");
}

}  // namespace
}  // namespace headframe
