// Updates of poses between a robot and the store, also of sessions with parts.
#include "tests/support/split_sessions.hpp"

namespace headframe {
namespace {

class HubPoses : public HubParts {
 protected:
  void move(std::uint64_t number, std::uint64_t keyframes, const std::vector<std::uint64_t>& sequences) {
    PosesReceived event{number, keyframes, {}};
    for (const std::uint64_t s : sequences)
      event.poses.push_back({s, pose_from_yaw(0, {10.0 * static_cast<double>(s), 0, 0})});
    hub_->take(id_, event, link_);
    settle();
  }
  Numbers moved(SessionId session) const {
    Numbers out;
    const auto waiting = store_->new_poses(session);
    for (const KeyframePose& pose : waiting->poses) out.push_back(pose.sequence);
    return out;
  }
};

TEST_F(HubPoses, AnUpdateIsDurableBeforeItIsAcknowledgedAndTheWorkerHearsOfIt) {
  keyframes(1, 5);
  move(2, 5, {1, 3});
  EXPECT_EQ(link_->updates_of_poses, Numbers{2});
  EXPECT_TRUE(news_.has("poses 1"));
  EXPECT_EQ(moved(1), (Numbers{1, 3}));
  move(2, 5, {1, 3});
  EXPECT_EQ(link_->updates_of_poses, (Numbers{2, 2})) << "a repeat is acknowledged";
  for (const bool restarted : {false, true}) {
    restarted ? start() : come();
    EXPECT_EQ(durable_.pose_update, 2U) << restarted;
  }
}

TEST_F(HubPoses, OneOfAKeyframeThatIsNotStoredIsNotAcknowledged) {
  keyframes(1, 5);
  move(1, 6, {6});
  EXPECT_TRUE(link_->updates_of_poses.empty());
  EXPECT_FALSE(link_->stored) << "the connection ends, and the robot says it again";
}

TEST_F(HubPoses, OfASessionWithPartsEachGetsItsOwn) {
  keyframes(1, 7);
  cut(1, 4);
  move(1, 7, {2, 3, 5, 7});
  EXPECT_EQ(moved(1), (Numbers{2, 3}));
  EXPECT_EQ(moved(2), (Numbers{2, 4}));
  EXPECT_EQ(store_->new_poses(2)->keyframes, 4U);
  EXPECT_TRUE(news_.has("poses 2"));
  start();
  EXPECT_EQ(durable_.pose_update, 1U);
  move(2, 7, {6});
  EXPECT_EQ(moved(2), (Numbers{2, 3, 4}));
  EXPECT_EQ(link_->updates_of_poses, Numbers{2});
}

TEST_F(HubPoses, WhatWaitsGoesAlongWhenTheSessionIsSplit) {
  keyframes(1, 7);
  move(1, 7, {2, 5});
  cut(1, 4);
  EXPECT_EQ(moved(1), Numbers{2});
  EXPECT_EQ(moved(2), Numbers{2});
  EXPECT_TRUE(news_.has("poses 2"));
}

}  // namespace
}  // namespace headframe
