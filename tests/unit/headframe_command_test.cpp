// What the command shows and asks for.
#include "tests/support/headframe_command_fixture.hpp"

namespace headframe {
namespace {

TEST_F(HeadframeCommand, SessionsSaysWhichCanNotMeetForTheirFamilies) {
  server.station.rows[1].family.version = 2;
  server.station.rows[2].family = {"lidar_iris", 1};
  const Outcome sessions = run("sessions");
  EXPECT_NE(sessions.out.find("not compared across these descriptor families\n"
                              "  lidar_iris version 1: gamma \"3\"/run/1\n"
                              "  scan_context version 1: alpha/run/1\n"
                              "  scan_context version 2: beta/run/1\n"),
            std::string::npos)
      << sessions.out;
  for (int i = 0; i < 8; ++i) server.station.rows.push_back(server.station.rows[0]);
  EXPECT_NE(run("sessions").out.find("alpha/run/1 and 1 more\n"), std::string::npos);
}

TEST_F(HeadframeCommand, ShowsStatusSessionsAndAtlas) {
  const Outcome status = run("status");
  EXPECT_EQ(status.code, 0) << status.err;
  EXPECT_NE(status.out.find("revision 7, 2 components of 3 sessions\n"), std::string::npos) << status.out;
  EXPECT_NE(status.out.find("pending     nothing\n"), std::string::npos) << status.out;

  server.station.rows[0].key.robot = "\x1b[31mred";
  const Outcome sessions = run("sessions");
  EXPECT_EQ(sessions.code, 0) << sessions.err;
  EXPECT_EQ(std::count(sessions.out.begin(), sessions.out.end(), '\n'), 4);
  EXPECT_NE(sessions.out.find("?[31mred/run/1"), std::string::npos) << "names do not reach the terminal raw";
  EXPECT_NE(sessions.out.find("live"), std::string::npos);
  EXPECT_NE(sessions.out.find("1.0 kB"), std::string::npos);

  EXPECT_EQ(sessions.out.find("not compared"), std::string::npos) << "all of one family";

  const Outcome atlas = run("atlas");
  EXPECT_EQ(atlas.code, 0) << atlas.err;
  EXPECT_NE(atlas.out.find("revision 7: 2 components of 3 sessions\n"), std::string::npos) << atlas.out;
  EXPECT_NE(atlas.out.find("90.00"), std::string::npos) << atlas.out;
  EXPECT_NE(atlas.out.find("published"), std::string::npos) << atlas.out;
  EXPECT_NE(atlas.out.find("0.970"), std::string::npos) << atlas.out;
}

TEST_F(HeadframeCommand, JsonIsTheApisOwn) {
  EXPECT_EQ(Json::parse(run("status --json").out)["revision"], 7);
  EXPECT_EQ(Json::parse(run("--json sessions").out)["sessions"].size(), 3U);
  EXPECT_EQ(Json::parse(run("atlas --json").out)["components"].size(), 2U);
  EXPECT_EQ(Json::parse(run("merge --json").out)["waited_out"], false);
  const Json exported = Json::parse(run("export --json --component 1 " + path("a.ply")).out);
  EXPECT_EQ(exported["bytes"], fs::file_size(path("a.ply")));
  EXPECT_EQ(Json::parse(run("trajectory --json alpha " + path("a.txt")).out)["session"], "run/1");
}

TEST_F(HeadframeCommand, WaitReturnsWhenNothingIsPending) {
  server.station.set_pending({1, 0, 0});
  std::jthread settle([&] {
    while (server.station.waits == 0) std::this_thread::yield();
    server.station.set_pending({});
  });
  const Outcome atlas = run("atlas --json --wait 600");
  EXPECT_EQ(atlas.code, 0) << atlas.err;
  EXPECT_EQ(Json::parse(atlas.out)["waited_out"], false);
  EXPECT_EQ(atlas.err, "");
}

TEST_F(HeadframeCommand, WaitThatRunsOutPrintsTheAtlasAndWhatIsPending) {
  server.station.set_pending({1, 0, 2});
  for (const char* arguments : {"atlas --wait 0", "atlas --wait 0.05", "merge --wait 0.05"}) {
    const Outcome atlas = run(arguments);
    EXPECT_EQ(atlas.code, 3) << arguments;
    EXPECT_NE(atlas.out.find("revision 7"), std::string::npos) << arguments;
    EXPECT_NE(atlas.err.find("still pending: 1 attempt, 2 awaited submaps\n"), std::string::npos) << atlas.err;
  }
}

TEST_F(HeadframeCommand, MergeTriggersAndShowsProgressUntilItIsSettled) {
  server.station.merge_makes_work = true;
  std::jthread settle([&] {
    while (server.station.waits < 2) std::this_thread::yield();  // one slice of the wait ran out
    server.station.set_pending({});
  });
  const Outcome merge = run("merge");
  EXPECT_EQ(merge.code, 0) << merge.err;
  EXPECT_EQ(server.station.merges, 1);
  EXPECT_EQ(merge.err, "pending: 3 attempts\nsettled\n");
  EXPECT_NE(merge.out.find("revision 7"), std::string::npos);
}

TEST_F(HeadframeCommand, ExportsAndTrajectoriesBecomeFiles) {
  EXPECT_EQ(run("export --component 1 " + path("map.ply")).code, 0);
  EXPECT_EQ(run("export --component 1 --voxel 0 " + path("map.pcd")).code, 0);
  EXPECT_EQ(run("export --component beta " + path("map.ply")).out.rfind(path("map.ply") + ": component 1, ", 0), 0U)
      << "a component is known by any of its sessions";
  expect_fault(run("export --component delta " + path("map.ply")), 1, "there is no session \"delta\"");
  EXPECT_EQ(contents(path("map.ply")).substr(0, 4), "ply\n");
  EXPECT_NE(contents(path("map.pcd")).find("POINTS 40\n"), std::string::npos);
  EXPECT_EQ(run("trajectory beta " + path("by_robot.txt")).code, 0);
  EXPECT_EQ(run("trajectory beta/run/1 " + path("by_session.txt")).code, 0);
  EXPECT_EQ(contents(path("by_robot.txt")), contents(path("by_session.txt")));
  EXPECT_EQ(run("trajectory 'gamma \"3\"' " + path("odd.txt")).code, 0) << "a name with spaces and quotes";
  EXPECT_EQ(files(), (std::set<std::string>{"map.ply", "map.pcd", "by_robot.txt", "by_session.txt", "odd.txt"}));
}

TEST_F(HeadframeCommand, DecisionsAreOneLine) {
  expect_fault(run("confirm 2"), 1, "its probability is 0.000, and a wrong merge");
  EXPECT_TRUE(server.station.decided.empty());
  server.station.change([&] {
    server.station.view.alignments[1].alignment.state = AlignmentState::verified;
    server.station.view.alignments[1].alignment.evidence.probability = 0.99;
  });
  expect_fault(run("confirm 2"), 1, "other sessions contradict it");
  EXPECT_EQ(run("confirm --yes 2").out,
            "alignment 2, alpha/run/1 and gamma \"3\"/run/1: published, confirmed; revision 7\n");
  EXPECT_NE(run("alignments").out.find("published, confirmed"), std::string::npos);
  server.station.change([&] { server.station.view.alignments[0].alignment.state = AlignmentState::rejected; });
  EXPECT_NE(run("alignments --most 0").out.find("1 older pair that came to nothing left out"), std::string::npos);
  expect_fault(run("alignments --most all"), 2, "all");
  EXPECT_EQ(run("undo 2").code, 0);
  EXPECT_EQ(server.station.decided.back(), std::pair(AlignmentId{2}, Decision::undo));
  EXPECT_EQ(Json::parse(run("refuse --json 2").out)["alignment"]["id"], 2);
  expect_fault(run("retract 9"), 1, "no such alignment");
  expect_fault(run("confirm first"), 1, "\"first\" is no alignment");
  expect_fault(run("confirm"), 2, "ALIGNMENT");
}

TEST_F(HeadframeCommand, ExplainsInWords) {
  server.station.view.alignments[0].alignment.evidence.inlier_fraction = 0.9;
  server.station.view.alignments[0].alignment.evidence.overlap_m = 24;
  const Outcome why = run("explain alpha beta");
  EXPECT_EQ(why.code, 0) << why.err;
  EXPECT_NE(why.out.find("  24 m of path are shared"), std::string::npos) << why.out;
  EXPECT_EQ(why.out.rfind("alpha/run/1 and beta/run/1 are merged: at x 10.0", 0), 0U) << why.out;
  EXPECT_NE(why.out.find("  + 0.0  0.00 % of the points lie"), std::string::npos) << why.out;
  EXPECT_NE(why.out.find("gates\n  + upright: "), std::string::npos) << why.out;
  EXPECT_NE(run("explain alpha 'gamma \"3\"'").out.find("missing\n    they do not meet"), std::string::npos);
  expect_fault(run("explain alpha delta"), 1, "no session \"delta\"");
  expect_fault(run("explain alpha"), 2, "B is required");
}

TEST_F(HeadframeCommand, ListsWhatChangedInTheMine) {
  EXPECT_EQ(run("changes").out.rfind("no change", 0), 0U);
  server.station.view.alignments[0].alignment.changes = {
      {ChangeKind::excavated, {1, 2, 3}, 4, 2, 3, false, 1.7e9, 1.71e9}};
  const Outcome all = run("changes --since 2024-03-09");
  EXPECT_EQ(all.code, 0) << all.err;
  EXPECT_NE(all.out.find("excavated"), std::string::npos) << all.out;
  EXPECT_NE(all.out.find("2023-11-14 22:13"), std::string::npos) << "1.7e9 s: " << all.out;
  EXPECT_NE(all.out.find("2024-03-09 16:00"), std::string::npos) << all.out;
  EXPECT_EQ(run("changes --since 2024-03-10").out.rfind("no change", 0), 0U);
  EXPECT_EQ(Json::parse(run("changes --json").out)["changes"][0]["older"]["robot"], "alpha");
  server.station.view.alignments[0].alignment.evidence.inlier_fraction = 0.9;
  EXPECT_NE(run("explain alpha beta").out.find("excavated at x 1.0, y 2.0, z 3.0 m, 4.0 x 2.0 x 3.0 m"),
            std::string::npos);
  for (const char* wrong : {"2026-02-29", "2026-1-1", "yesterday", "2026-11-231"})
    expect_fault(run(std::string("changes --since ") + wrong), 2, "write YYYY-MM-DD");
}

TEST_F(HeadframeCommand, ASessionIsSetAsideReleasedAndDeleted) {
  EXPECT_EQ(run("session quarantine beta --reason 'its lidar is loose'").out,
            "beta/run/1 is set aside; session release takes it back\n");
  EXPECT_NE(run("sessions").out.find("set aside: its lidar is loose"), std::string::npos);
  EXPECT_EQ(run("session release beta").out, "beta/run/1 is merged again\n");
  expect_fault(run("session release beta"), 1, "not set aside");
  const Outcome asked = run("session delete alpha");
  EXPECT_EQ(asked.code, 1);
  EXPECT_NE(asked.err.find("alpha/run/1: 3 keyframes, 2 clouds are deleted\n"), std::string::npos) << asked.err;
  EXPECT_NE(asked.err.find("merged with beta/run/1"), std::string::npos) << asked.err;
  EXPECT_NE(asked.err.find("anchored to it"), std::string::npos) << asked.err;
  EXPECT_NE(asked.err.find("--yes"), std::string::npos) << asked.err;
  EXPECT_EQ(run("session delete beta --yes").out, "beta/run/1 is deleted\n");
  expect_fault(run("session delete beta --yes"), 1, "beta");
}

TEST_F(HeadframeCommand, ASessionIsArchivedFrozenAndNoted) {
  EXPECT_EQ(run("session archive beta").out, "beta/run/1 is archived; session restore brings it back\n");
  EXPECT_NE(run("sessions").out.find("archived"), std::string::npos);
  EXPECT_NE(run("explain alpha beta").out.find("beta/run/1 is archived"), std::string::npos);
  expect_fault(run("session archive beta"), 1, "archived already");
  EXPECT_EQ(run("session restore beta").out, "beta/run/1 is back\n");
  EXPECT_EQ(run("session freeze beta").out, "beta/run/1 is frozen; session thaw lets it move again\n");
  EXPECT_NE(run("sessions").out.find("frozen"), std::string::npos);
  EXPECT_EQ(run("session thaw beta").out, "beta/run/1 may move again\n");
  EXPECT_EQ(run("session note beta").out, "beta/run/1 has no note\n");
  EXPECT_EQ(run("session note beta 'the old shaft is flooded'").out, "beta/run/1: noted\n");
  EXPECT_EQ(run("session note beta").out, "the old shaft is flooded\n");
  EXPECT_EQ(run("session note beta ''").out, "beta/run/1 has no note now\n");
  expect_fault(run("session archive delta"), 1, "no session \"delta\"");
}

TEST_F(HeadframeCommand, SessionsAndRobotsBelongToSites) {
  EXPECT_EQ(run("site list").out, "(no site): 3 sessions\n");
  EXPECT_EQ(run("sessions").out.find("site"), std::string::npos) << "nobody needs to know of them";
  EXPECT_EQ(run("site session beta north").out,
            "beta/run/1 is of the site north; it is merged with those there alone\n");
  EXPECT_EQ(run("site robot ant south").out,
            "sessions that ant begins from now on are of the site south; those it began stay where they are: headframe "
            "site session takes one there\n");
  EXPECT_EQ(run("site list").out,
            "(no site): 2 sessions\nnorth: 1 session\nsouth: 0 sessions; also what these begin: "
            "ant\n");
  EXPECT_NE(run("sessions").out.find("north"), std::string::npos);
  EXPECT_NE(
      run("explain beta 'gamma \"3\"'").out.find("beta/run/1 is of the site north, gamma \"3\"/run/1 is of no site"),
      std::string::npos);
  EXPECT_EQ(run("site session beta").out, "beta/run/1 is of no site; it is merged with those there alone\n");
  expect_fault(run("site session delta north"), 1, "no session \"delta\"");
  expect_fault(run("site robot"), 2, "NAME");
}

TEST_F(HeadframeCommand, SessionsGetLabelsAnchorsAndClouds) {
  EXPECT_EQ(run("rename beta 'north drift'").out, "beta/run/1: north drift\n");
  EXPECT_NE(run("sessions").out.find("beta/run/1 (north drift)"), std::string::npos);
  EXPECT_NE(run("atlas").out.find("beta/run/1 (north drift)"), std::string::npos);
  EXPECT_EQ(run("anchor 'north drift'").out, "component 1 is in the frame of beta/run/1; revision 7\n");
  EXPECT_EQ(server.station.anchored, std::vector<SessionId>{2});
  EXPECT_EQ(Json::parse(run("request-clouds beta --json").out)["requested"], 1);
  expect_fault(run("request-clouds alpha"), 1, "away");
  expect_fault(run("anchor delta"), 1, "no session \"delta\"");
  EXPECT_EQ(run("rename beta ''").out, "beta/run/1 has no label now\n");
  expect_fault(run("rename beta"), 2, "LABEL");
}

TEST_F(HeadframeCommand, SurveysComeFromFilesOfControlPoints) {
  EXPECT_NE(run("survey list").out.find("no survey yet"), std::string::npos);
  std::ofstream(path("points.csv")) << "name,x,y,z,e,n,h\n# a comment\nP1,0,0,0,1000,2000,3\nP2,50,0,0,1050,2000.02,3\n"
                                    << "P3,0, 50 ,0,1000,2050,3\n";
  const Outcome set = run("survey set beta " + path("points.csv"));
  EXPECT_EQ(set.code, 0) << set.err;
  EXPECT_NE(set.out.find("beta/run/1: origin at "), std::string::npos) << set.out;
  EXPECT_NE(set.out.find("  P2     1050.000  2000.020     3.000"), std::string::npos) << set.out;
  EXPECT_EQ(run("survey list").out, set.out);
  EXPECT_EQ(Json::parse(run("survey list --json").out)["surveys"].size(), 1U);
  std::ofstream(path("points.csv"))
      << "Punkt;x;y;z;Ost;Nord;H\r\nP1;0;0;0;1000;2000;3\r\nP2;50;0;0;1050;2000,02;3\r\nP3;0;50;0;1000;2050;3\r\n";
  EXPECT_EQ(run("survey set beta " + path("points.csv")).out, set.out) << "semicolons and decimal commas";
  std::ofstream(path("points.csv"))
      << "P1 0 0 0 1000 2000 3\nP2\t50\t0\t0\t1050\t2000.02\t3\nP3 0 50 0   1000 2050 3\n";
  EXPECT_EQ(run("survey set beta " + path("points.csv")).out, set.out) << "blanks and tabs";
  std::ofstream(path("points.csv"), std::ios::app) << "P4 50 50 0 1050 2050 5\n";
  expect_fault(run("survey set beta " + path("points.csv")), 1, "P4 is likely wrong");
  expect_fault(run("survey set beta " + path("points.csv")), 1, "--accept");
  EXPECT_NE(run("survey set beta --accept " + path("points.csv")).out.find("P4 is likely wrong"), std::string::npos);
  EXPECT_EQ(run("export --component 1 --frame grid " + path("map.las")).code, 0);
  EXPECT_EQ(run("export --component 1 --frame grid --format png " + path("plan")).code, 0);
  EXPECT_EQ(contents(path("plan")).substr(1, 3), "PNG");
  EXPECT_EQ(run("trajectory beta --frame grid " + path("beta.csv")).code, 0);
  EXPECT_EQ(run("survey drop beta").out, "beta/run/1 has no survey now\n");
  expect_fault(run("survey drop beta"), 1, "no survey");
  expect_fault(run("export --component 1 --frame grid " + path("map2.las")), 1, "surveyed");
  expect_fault(run("export --component 1 --frame moon " + path("map2.las")), 2, "moon");
  std::ofstream(path("bad.csv")) << "P1,0,0,0,1000,2000\n";
  expect_fault(run("survey set beta " + path("bad.csv")), 1, "bad.csv, line 1: give name,x_session");
  std::ofstream(path("bad.json")) << "{}";
  expect_fault(run("survey set beta " + path("bad.json")), 1, "one of T_grid_session and points");
  expect_fault(run("survey set beta " + path("none.csv")), 1, "there is no file");
  expect_fault(run("survey"), 2, "headframe survey has list, set, drop");
}

TEST_F(HeadframeCommand, AnOverlayIsAHistogram) {
  server.station.view.alignments[0].alignment.evidence.inlier_fraction = 0.9;
  server.station.view.alignments[0].alignment.T_a_b = Pose(Eigen::Translation3d(0, 0, 0.05));
  server.station.floor = true;
  const Outcome overlay = run("overlay 1");
  EXPECT_EQ(overlay.code, 0) << overlay.err;
  EXPECT_NE(overlay.out.find("0 points of b have no surface"), std::string::npos) << overlay.out;
  EXPECT_NE(overlay.out.find(std::string(50, '#')), std::string::npos) << overlay.out;
  EXPECT_LE(Json::parse(run("overlay 1 --json --most 20").out)["a"].size(), 20U);
  expect_fault(run("overlay 2"), 1, "nothing fitted");
}

TEST_F(HeadframeCommand, WatchShowsStatusAndSessionsAgain) {
  const std::string out = run("watch --times 2 --every 0.01").out;
  const auto first = out.find("revision 7, 2 components");
  ASSERT_NE(first, std::string::npos) << out;
  EXPECT_NE(out.find("beta/run/1", first), std::string::npos);
  EXPECT_NE(out.find("revision 7, 2 components", first + 1), std::string::npos) << out;
  EXPECT_EQ(Json::parse(run("watch --json --times 1").out)["revision"], 7);
  expect_fault(run_at("127.0.0.1:1", "watch"), 1, "no headframe-server answers");
}

}  // namespace
}  // namespace headframe
