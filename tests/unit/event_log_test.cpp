#include "server/operator/event_log.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "server/operator/log_lines.hpp"
#include "server/operator/router.hpp"
#include "tests/support/fake_station.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

std::vector<std::string> texts(const std::vector<LogEntry>& entries) {
  std::vector<std::string> out;
  out.reserve(entries.size());
  for (const LogEntry& entry : entries) out.push_back(entry.text);
  return out;
}

using Texts = std::vector<std::string>;

TEST(EventLog, IsThereAfterARestartAndCountsOn) {
  const TempDir folder;
  const auto file = folder.path() / "events.jsonl";
  for (int run = 0; run < 3; ++run) EventLog(file).add({"started", "run " + std::to_string(run)});
  EventLog log(file);
  EXPECT_EQ(texts(log.latest(2)), (Texts{"run 1", "run 2"}));
  EXPECT_EQ(log.newest(), 3U);
  EXPECT_EQ(texts(log.since(1)), (Texts{"run 1", "run 2"}));
}

TEST(EventLog, ALineThatIsDamagedOrCutOffCostsItselfAlone) {
  const TempDir folder;
  const auto file = folder.path() / "events.jsonl";
  EventLog(file).add({"started", "before"});
  std::ofstream(file, std::ios::app)
      << "{\"id\":2,\"kind\":7}\nno json\n[1]\n{\"id\":1e300,\"kind\":\"k\"}\n{\"id\":-4,\"kind\":\"k\"}\n"
         "{\"id\":18446744073709551615,\"kind\":\"k\"}\n{\"id\": 3, \"kind\": \"mer";
  EventLog(file).add({"started", "after"});
  EXPECT_EQ(texts(EventLog(file).latest(9)), (Texts{"before", "after"}));
}

TEST(EventLog, KeepsSoManyAndItsFileStaysSmall) {
  const TempDir folder;
  const auto file = folder.path() / "events.jsonl";
  {
    EventLog log(file, {.entries = 5, .file_bytes = 2000});
    for (int i = 0; i < 200; ++i) log.add({"started", std::to_string(i)});
    EXPECT_EQ(texts(log.latest(9)), (Texts{"195", "196", "197", "198", "199"}));
  }
  EXPECT_LT(std::filesystem::file_size(file), 3000U);
  EventLog again(file, {.entries = 5, .file_bytes = 2000});
  EXPECT_EQ(texts(again.latest(1)), Texts{"199"});
  EXPECT_EQ(again.newest(), 200U);
}

TEST(EventLog, WithoutAFileThatCanBeWrittenItIsKeptInMemory) {
  EventLog log("/nowhere/events.jsonl");
  log.add({"started", "here"});
  EXPECT_EQ(texts(log.latest(1)), Texts{"here"});
}

/// What is written down when the first alignment goes from one state to another, with such a decision.
std::vector<LogEntry> change(AlignmentState from, AlignmentState to, Ruling ruling = Ruling::none) {
  FakeStation station;
  station.view.alignments[0].alignment.state = from;
  const StationLook before = look_at(station);
  station.view.alignments[0].alignment.state = to;
  station.view.alignments[0].alignment.ruling = ruling;
  return log_lines(before, look_at(station));
}

TEST(LogLines, AMergeThatStandsNoMoreWasWithdrawnUnlessAnOperatorSaidSo) {
  for (const auto to :
       {AlignmentState::verified, AlignmentState::candidate, AlignmentState::retracted, AlignmentState::rejected}) {
    const auto lines = change(AlignmentState::published, to);
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_EQ(lines[0].kind, "withdrawn");
    EXPECT_EQ(lines[0].text.rfind("The merge of alpha/run/1 and beta/run/1 was withdrawn: ", 0), 0U) << lines[0].text;
    EXPECT_EQ(lines[0].alignment, 1);
  }
  EXPECT_TRUE(change(AlignmentState::published, AlignmentState::retracted, Ruling::retracted).empty());
}

TEST(LogLines, ASessionThatWasTakenToAnotherSiteRaisesNoAlarm) {
  for (const Ruling ruling : {Ruling::none, Ruling::confirmed}) {
    FakeStation station;
    station.view.alignments[0].alignment.ruling = ruling;
    const StationLook before = look_at(station);
    station.rows[0].site = "north";
    station.view.alignments[0].alignment.state = AlignmentState::rejected;
    EXPECT_EQ(log_lines(before, look_at(station)).empty(), ruling == Ruling::none) << "what he confirmed was to stand";
  }
}

TEST(LogLines, WhatBecomesOfAPair) {
  EXPECT_EQ(change(AlignmentState::verified, AlignmentState::published).at(0).kind, "merged");
  EXPECT_EQ(change(AlignmentState::candidate, AlignmentState::verified).at(0).kind, "held_back");
  EXPECT_EQ(change(AlignmentState::rejected, AlignmentState::candidate).at(0).kind, "unsure");
  EXPECT_EQ(change(AlignmentState::candidate, AlignmentState::rejected).at(0).kind, "no_match");
  EXPECT_TRUE(change(AlignmentState::published, AlignmentState::published).empty());
}

TEST(LogLines, RobotsComeEndAndGo) {
  FakeStation station;
  StationLook before = look_at(station);
  station.rows[1].complete = true;
  station.rows[1].connected = false;
  before.sessions.pop_back();
  EXPECT_EQ(texts(log_lines(before, look_at(station))),
            (Texts{"beta/run/1 finished: 3 keyframes.", "beta/run/1 left.", "gamma \"3\"/run/1 connected."}));
}

TEST(LogLines, AJumpOfTheOdometryIsSaidAndWhereItEndedASessionThatIsNoGoodbye) {
  FakeStation station;
  const StationLook before = look_at(station);
  station.rows[1].why_cut = "from keyframe 4 on it is session run/1~4";
  station.rows[1].complete = true;
  station.rows[1].connected = false;
  EXPECT_EQ(texts(log_lines(before, look_at(station))), Texts{"beta/run/1: from keyframe 4 on it is session run/1~4."});
  const StationLook later = look_at(station);
  EXPECT_EQ(texts(log_lines(later, look_at(station))), Texts{});
}

TEST(LogLines, CloudsThatMadeRoomAreWrittenDownWhoeverLetThemGo) {
  FakeStation station;
  StationLook before = look_at(station);
  station.rows[1].let_go = 2;
  const auto lines = log_lines(before, look_at(station));
  EXPECT_EQ(texts(lines), Texts{"2 clouds of beta/run/1 made room: later sessions keep that rock."});
  EXPECT_EQ(lines.at(0).session, 2);
  EXPECT_EQ(operator_line("POST", "/api/v1/store/let-go", {}, station, "anna")->text, "anna let covered clouds go.");
  before = look_at(station);
  EXPECT_TRUE(log_lines(before, look_at(station)).empty());
  before.sessions.erase(before.sessions.begin() + 1);
  EXPECT_TRUE(texts(log_lines(before, look_at(station))) == Texts{"beta/run/1 connected."}) << "it came with them";
}

TEST(LogLines, EveryRequestThatChangesSomethingHasALineAndNoOther) {
  const FakeStation station;
  std::size_t without = 0;
  for (const RouteName& route : route_names()) {
    const auto line = operator_line(
        route.method, route.path,
        {{"id", "1"}, {"decision", "confirm"}, {"session", "2"}, {"robot", "ant"}, {"kib_s", "8"}}, station);
    const bool tells_itself = route.path.starts_with("/api/v1/notes");  // it knows what was written
    EXPECT_EQ(line.has_value(), route.method != "GET" && !tells_itself) << route.path;
    without += line ? 0 : 1;
  }
  EXPECT_GT(without, 10U);
  EXPECT_EQ(operator_line("DELETE", "/api/v1/sessions/{id}", {{"id", "2"}}, station)->text,
            "An operator deleted beta/run/1.");
  EXPECT_EQ(operator_line("POST", "/api/v1/sessions/{id}/rename", {{"id", "2"}, {"name", "east"}}, station)->text,
            "An operator called beta/run/1 \"east\".");
}

}  // namespace
}  // namespace headframe
