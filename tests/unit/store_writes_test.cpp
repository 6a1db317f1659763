// What a store refuses, and what it takes twice, over both databases.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>

#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

using StoreWrites = OverBothStores;
OVER_BOTH_STORES(StoreWrites);

TEST_P(StoreWrites, RepeatsChangeNothingAndHolesFail) {
  const StoreHome dir(GetParam());
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

TEST_P(StoreWrites, AnotherKeyframeOfTheSameNumberFails) {
  const std::vector<std::pair<std::string, std::function<void(Keyframe&)>>> changes{
      {"another stamp", [](Keyframe& k) { k.stamp_s += 1e-6; }},
      {"another pose", [](Keyframe& k) { k.T_local_sensor.translation().z() += 0.01; }},
      {"another descriptor", [](Keyframe& k) { k.descriptor.q.back() += 1; }},
      {"another descriptor", [](Keyframe& k) { k.descriptor.w.pop_back(); }},
      {"another descriptor", [](Keyframe& k) { k.descriptor.place_class = PlaceClass::junction; }},
      {"other walls", [](Keyframe& k) { k.walls.code.back() = 1; }},
      {"another scan", [](Keyframe& k) { k.point_count = 0; }},
      {"another scan", [](Keyframe& k) { k.spaciousness_m = 9; }}};
  const StoreHome dir(GetParam());
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

TEST_P(StoreWrites, ASplitSessionGoesOnAsAnotherOne) {
  const StoreHome dir(GetParam());
  auto store = open(dir);
  ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  for (std::uint64_t i = 1; i <= 6; ++i) {
    ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(i)}));
    ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, i}, "cloud " + std::to_string(i)}));
  }
  ASSERT_TRUE(write_and_wait(*store, LetGo{{{1, 2}, {1, 5}}}));
  store.reset();  // one of its rows is damaged meanwhile
  ASSERT_TRUE(dir.database()->execute("UPDATE keyframes SET spaciousness_m=77 WHERE sequence=4"));
  store = open(dir);
  SessionRecord part = session_record(2, "ant");
  part.key.session = "s1~3";
  part.spool_run = 9;
  for (int twice = 0; twice < 2; ++twice) {
    ASSERT_TRUE(write_and_wait(*store, SplitSession{1, 3, part}));
    EXPECT_EQ(keyframes(*store, 1).size(), 2U);
    const auto moved = keyframes(*store, 2);
    ASSERT_EQ(moved.size(), 4U);
    for (const std::uint64_t i : {1, 3, 4}) {
      EXPECT_EQ(moved[i - 1].sequence, i);
      EXPECT_EQ(moved[i - 1].descriptor.q, line_keyframe(i + 2).descriptor.q);
    }
    EXPECT_TRUE(moved[1].descriptor.q.empty()) << "damaged before, damaged now";
    EXPECT_EQ(store->cloud_sequences(1).value(), (std::vector<std::uint64_t>{1}));
    EXPECT_EQ(store->cloud_sequences(2).value(), (std::vector<std::uint64_t>{1, 2, 4}));
    EXPECT_EQ(store->let_go(1).value(), (std::vector<std::uint64_t>{2}));
    EXPECT_EQ(store->let_go(2).value(), (std::vector<std::uint64_t>{3}));
    EXPECT_EQ(store->cloud({2, 4}).value(), "cloud 6");
    const auto sessions = store->sessions().value();
    ASSERT_EQ(sessions.size(), 2U);
    EXPECT_TRUE(sessions[0].complete);
    EXPECT_FALSE(sessions[1].complete);
    EXPECT_EQ(sessions[1].key.session, "s1~3");
    EXPECT_EQ(sessions[1].spool_run, 9U);
  }
  EXPECT_TRUE(write_and_wait(*store, PutKeyframe{2, line_keyframe(5)}));
}

TEST_P(StoreWrites, WrongKeyframesDoNotSplitTheCommitThatTheyCameWith) {
  const StoreHome dir(GetParam());
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

TEST_P(StoreWrites, FullQueueRefusesAtOnce) {
  const StoreHome dir(GetParam());
  const auto store = open(dir, {.queue_bytes = 4096});
  EXPECT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
  const auto refused = write_and_wait(*store, PutCloud{{1, 1}, std::string(4096, 'x')});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
  EXPECT_EQ(store->load().queued_bytes, 0U);
}

}  // namespace
}  // namespace headframe
