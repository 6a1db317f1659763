// Where keyframes lie that a robot's SLAM moved, over both stores.
#include "tests/support/both_stores.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

class StorePoses : public OverBothStores {
 protected:
  void SetUp() override {
    OverBothStores::SetUp();
    if (IsSkipped()) return;
    home_.emplace(GetParam());
    store_ = open(*home_);
    for (const SessionId id : {1, 2}) {
      keep(PutSession{session_record(id, "robot" + std::to_string(id))});
      for (std::uint64_t s = 1; s <= 6; ++s) keep(PutKeyframe{id, line_keyframe(s)});
    }
  }
  void keep(Write write) { ASSERT_TRUE(write_and_wait(*store_, std::move(write))); }
  /// What merging does with update 1.
  void take_in_first() {
    PutMerge taken;
    taken.moved = MovedPoses{1, 1, store_->new_poses(1)->poses};
    keep(std::move(taken));
  }
  static KeyframePose at(std::uint64_t sequence, double x) { return {sequence, pose_from_yaw(0.1, {x, 0, 0})}; }
  static PutPoses update(std::uint64_t number, std::uint64_t keyframes, std::vector<KeyframePose> poses,
                         SessionId session = 1) {
    return {session, number, {{session, {keyframes, std::move(poses)}}}};
  }
  double x(std::uint64_t sequence, SessionId session = 1) {
    return position(keyframes(*store_, session).at(sequence - 1)).x();
  }
  std::uint64_t durable() { return store_->sessions()->at(0).pose_update; }
  void reopen() {
    store_.reset();
    store_ = open(*home_);
  }

  std::optional<StoreHome> home_;
  std::unique_ptr<Store> store_;
};

TEST_P(StorePoses, WhatARobotSaidWaitsUntilMergingTakesItIn) {
  keep(update(3, 5, {at(2, 20), at(4, 40)}));
  keep(update(4, 6, {at(4, 41), at(6, 60)}));
  reopen();
  EXPECT_EQ(durable(), 4U);
  EXPECT_EQ(x(2), position(line_keyframe(2)).x()) << "as it came, for now";
  const auto waiting = store_->new_poses(1);
  ASSERT_TRUE(waiting);
  EXPECT_EQ(waiting->number, 4U);
  EXPECT_EQ(waiting->keyframes, 5U) << "what came behind the first of them lies in another frame";
  ASSERT_EQ(waiting->poses.size(), 3U);
  EXPECT_EQ(waiting->poses[1].T_local_sensor.translation().x(), 41);
  EXPECT_EQ(store_->new_poses(2)->number, 0U);

  keep(PutMerge{1, 6, {}, std::nullopt, {}});
  PutMerge taken;
  taken.moved = MovedPoses{1, 4, waiting->poses};
  keep(taken);
  reopen();
  EXPECT_EQ(x(2), 20);
  EXPECT_EQ(x(4), 41);
  EXPECT_EQ(x(3), position(line_keyframe(3)).x());
  EXPECT_EQ(store_->new_poses(1)->number, 0U);
  EXPECT_EQ(store_->sessions()->at(0).attempted_keyframes, 0U) << "it is tried again, also after a restart";
  EXPECT_EQ(keyframes(*store_, 1, 4).size(), 3U);
  const Keyframe moved = keyframes(*store_, 1).at(3);
  EXPECT_EQ(moved.descriptor.q, line_keyframe(4).descriptor.q);
  EXPECT_EQ(moved.stamp_s, line_keyframe(4).stamp_s);
}

TEST_P(StorePoses, WhatCameMeanwhileGoesOnWaiting) {
  keep(update(1, 6, {at(1, 10), at(2, 20)}));
  const auto taken_up = store_->new_poses(1);
  keep(update(2, 6, {at(2, 21)}));
  PutMerge taken;
  taken.moved = MovedPoses{1, taken_up->number, taken_up->poses};
  keep(taken);
  EXPECT_EQ(x(1), 10);
  EXPECT_EQ(x(2), 20) << "as merging has it";
  const auto waiting = store_->new_poses(1);
  EXPECT_EQ(waiting->number, 2U);
  ASSERT_EQ(waiting->poses.size(), 1U);
  EXPECT_EQ(waiting->poses[0].T_local_sensor.translation().x(), 21);
}

TEST_P(StorePoses, ARepeatAndAnOlderOneChangeNothing) {
  keep(update(5, 6, {at(1, 10)}));
  keep(update(5, 6, {at(1, 11)}));
  keep(update(4, 6, {at(2, 12)}));
  EXPECT_EQ(durable(), 5U);
  const auto waiting = store_->new_poses(1);
  ASSERT_EQ(waiting->poses.size(), 1U);
  EXPECT_EQ(waiting->poses[0].T_local_sensor.translation().x(), 10);
}

TEST_P(StorePoses, OneOfAKeyframeThatIsNotThereIsNotTakenAndOthersAre) {
  auto bad = update(1, 7, {at(1, 10), at(7, 70)});
  const auto done = write_and_wait(*store_, bad);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(durable(), 0U);
  EXPECT_TRUE(store_->new_poses(1)->poses.empty());
  EXPECT_FALSE(write_and_wait(*store_, update(1, 1, {at(1, 1)}, 9))) << "no such session";
  keep(update(1, 6, {at(6, 60)}));
  keep(PutKeyframe{1, line_keyframe(7)});
}

TEST_P(StorePoses, AKeyframeThatComesAgainIsComparedWithWhatCame) {
  keep(update(1, 6, {at(2, 20)}));
  take_in_first();
  keep(PutKeyframe{1, line_keyframe(2)});
  EXPECT_EQ(x(2), 20);
}

TEST_P(StorePoses, TheyGoWithAPartAndWithADeletedSession) {
  keep(update(1, 6, {at(2, 20), at(5, 50)}));
  take_in_first();
  keep(update(2, 6, {at(3, 30), at(6, 60)}));
  SessionRecord part = session_record(3, "robot1");
  part.key.session = "s1~4";
  keep(SplitSession{1, 4, part});
  EXPECT_EQ(x(2), 20);
  EXPECT_EQ(x(2, 3), 50);
  EXPECT_EQ(store_->new_poses(1)->poses.size(), 1U);
  const auto waiting = store_->new_poses(3);
  ASSERT_EQ(waiting->poses.size(), 1U);
  EXPECT_EQ(waiting->poses[0].sequence, 3U);
  EXPECT_EQ(waiting->keyframes, 3U);
  PutMerge deleted;
  deleted.trouble = PutTrouble{{1, 0, 0, "deleted", true}};
  keep(deleted);
  EXPECT_TRUE(store_->new_poses(1)->poses.empty());
}

TEST_P(StorePoses, ADamagedPoseIsNotBelieved) {
  keep(update(1, 6, {at(2, 20), at(3, 30)}));
  take_in_first();
  keep(update(2, 6, {at(4, 40), at(5, 50)}));
  store_.reset();
  {
    const auto database = home_->database();
    ASSERT_TRUE(database->execute("UPDATE moved_poses SET checksum = checksum + 1 WHERE sequence = 2"));
    ASSERT_TRUE(database->execute("UPDATE pose_updates SET checksum = checksum + 1 WHERE sequence = 4"));
  }
  store_ = open(*home_);
  EXPECT_EQ(x(2), x(1)) << "it stands where its neighbour does";
  EXPECT_EQ(keyframes(*store_, 1).at(1).point_count, 0U) << "and has seen nothing";
  EXPECT_EQ(x(3), 30);
  EXPECT_EQ(store_->new_poses(1)->poses.size(), 1U);
}

OVER_BOTH_STORES(StorePoses);

}  // namespace
}  // namespace headframe
