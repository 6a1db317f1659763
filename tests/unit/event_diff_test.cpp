#include "server/operator/event_diff.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/fake_station.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

std::vector<Json> events(const StationLook& before, const StationLook& after) {
  std::vector<Json> out;
  for (const std::string& event : events_between(before, after)) out.push_back(Json::parse(event));
  return out;
}

TEST(Events, NothingHappenedIsNothingTold) {
  const FakeStation station;
  EXPECT_TRUE(events_between(look_at(station), look_at(station)).empty());
}

TEST(Events, EachChangeIsToldOnce) {
  FakeStation station;
  const StationLook before = look_at(station);
  const auto told = [&](const char* type) {
    const auto all = events(before, look_at(station));
    EXPECT_EQ(all.size(), 1U) << type;
    EXPECT_EQ(all.at(0)["type"], type);
    station.rows = before.sessions;
    station.view = before.view;
    station.set_pending({});
    return all.at(0);
  };
  station.rows[0].connected = true;
  EXPECT_EQ(told("robot_connected")["robot"], "alpha");
  station.rows[1].connected = false;
  EXPECT_EQ(told("robot_left")["robot"], "beta");
  station.rows[1].keyframes = 17;
  EXPECT_EQ(told("keyframes")["keyframes"], 17);
  station.rows[1].why_cut = "from keyframe 7 on it is left out of merging";
  EXPECT_EQ(told("keyframes")["why_cut"], "from keyframe 7 on it is left out of merging");
  station.rows[0].live = LiveRow{{.battery = 0.5}, 0.2, 1};
  EXPECT_EQ(told("live")["live"]["battery"], 0.5);
  station.rows[2].label = "north drift";
  EXPECT_EQ(told("renamed")["label"], "north drift");
  station.view.alignments[1].alignment.state = AlignmentState::candidate;
  EXPECT_EQ(told("alignment")["alignment"]["state"], "candidate");
  station.view.alignments[0].alignment.T_a_b.translation().x() += 1;
  EXPECT_EQ(told("alignment")["alignment"]["id"], 1);
  station.view.atlas.revision = 8;
  EXPECT_EQ(told("revision")["revision"], 8);
  station.set_pending({2, 0, 0});
  EXPECT_EQ(told("pending")["pending"]["attempts"], 2);
}

TEST(Events, ARobotThatStandsStillIsToldWheneverItSaysSo) {
  FakeStation station;
  station.rows[0].live = LiveRow{{.stamp_s = 7}, 0.9, 3};
  const StationLook before = look_at(station);
  station.rows[0].live->age_s = 1.4;
  EXPECT_TRUE(events(before, look_at(station)).empty()) << "nothing was said since";
  station.rows[0].live = LiveRow{{.stamp_s = 7}, 0.1, 4};
  const auto all = events(before, look_at(station));
  ASSERT_EQ(all.size(), 1U) << "the same again, and it is alive";
  EXPECT_EQ(all[0]["type"], "live");
}

TEST(Events, ANewSessionIsToldWhole) {
  const FakeStation station;
  StationLook before = look_at(station);
  before.sessions.pop_back();
  const auto all = events(before, look_at(station));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["type"], "robot_connected");
  EXPECT_EQ(all[1]["type"], "keyframes");
  EXPECT_EQ(all[1]["sensor"]["beams"], 16);
}

TEST(Events, ASnapshotHoldsAll) {
  const FakeStation station;
  const Json snapshot = Json::parse(snapshot_event(look_at(station)));
  EXPECT_EQ(snapshot["type"], "snapshot");
  EXPECT_EQ(snapshot["sessions"]["sessions"].size(), 3U);
  EXPECT_EQ(snapshot["atlas"]["alignments"].size(), 1U);
  EXPECT_EQ(snapshot["atlas"]["rejected"], 1);
  EXPECT_EQ(snapshot["atlas"]["pending"]["attempts"], 0);
}

}  // namespace
}  // namespace headframe
