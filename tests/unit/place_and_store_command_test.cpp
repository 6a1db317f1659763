// headframe place, headframe store and headframe servers: what they show, and what they refuse.
#include "tests/support/headframe_command_fixture.hpp"

namespace headframe {
namespace {

TEST_F(HeadframeCommand, OneSessionIsLaidOnAnotherByHand) {
  const Outcome placed = run("place alpha beta --at 10 20 30 90");
  EXPECT_EQ(placed.code, 0) << placed.err;
  EXPECT_NE(placed.out.find("registration moved it by 0.50 m and 5.7 deg"), std::string::npos) << placed.out;
  EXPECT_NE(placed.out.find("headframe confirm 1 merges the two"), std::string::npos) << placed.out;
  EXPECT_NE(placed.out.find("placed by the operator"), std::string::npos) << placed.out;
  std::ofstream(path("spots.txt")) << "# in alpha, in beta\n10 20 30 0 0 0\n10,30,30, 10,0,0\n\n0;20;30;0;10;0\r\n";
  const Outcome by_pairs = run("place alpha beta --json --pairs " + path("spots.txt"));
  ASSERT_EQ(by_pairs.code, 0) << by_pairs.err;
  const Json T = Json::parse(by_pairs.out)["explanation"]["alignment"]["T_a_b"];
  const std::vector<double> wanted{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(T[i].get<double>(), wanted[i], 1e-9) << i;
  expect_fault(run("place alpha 'gamma \"3\"' --at 1 2 3 4"), 1, "nobody has clouds where the two would meet");
}

TEST_F(HeadframeCommand, WhatCanNotBePlacedIsOneClearLine) {
  expect_fault(run("place alpha beta"), 2, "say where B lies on A");
  expect_fault(run("place alpha beta --at 1 2 3"), 2, "--at");
  expect_fault(run("place alpha beta --at 1 2 3 east"), 2, "east");
  expect_fault(run("place alpha beta --at 1 2 3 nan"), 1, "give {");
  expect_fault(run("place alpha beta --at 1e9 0 0 0"), 1, "100000 km");
  expect_fault(run("place alpha alpha --at 1 2 3 4"), 1, "the same session");
  expect_fault(run("place alpha delta --at 1 2 3 4"), 1, "no session \"delta\"");
  expect_fault(run("place alpha beta --pairs " + path("none.txt")), 1, "no file");
  const auto pairs = [&](const std::string& text) {
    std::ofstream(path("spots.txt")) << text;
    return run("place alpha beta --pairs " + path("spots.txt"));
  };
  expect_fault(pairs("1 2 3 4 5 6\n1 2 3 4 5\n"), 1, "line 2: give x y z");
  expect_fault(pairs("1 2 3 4 5 six\n"), 1, "line 1");
  expect_fault(pairs(std::string("\x00\xff\xfe", 3)), 1, "line 1");
  expect_fault(pairs(""), 1, "three pairs of points or more, there are 0");
  expect_fault(pairs("0 0 0 0 0 0\n9 0 0 9 0 0\n"), 1, "there are 2");
  expect_fault(pairs("0 0 0 0 0 0\n.1 0 0 .1 0 0\n0 .1 9 0 .1 9\n"), 1, "within a metre of one spot");
  expect_fault(pairs("0 0 0 0 0 0\n90 0 0 9 0 0\n0 9 0 0 9 0\n"), 1, "contradict each other");
}

TEST_F(HeadframeCommand, WhatWouldGoForRoomIsShownBeforeItGoes) {
  const std::string shown = run("store show").out;
  EXPECT_NE(shown.find("free        1.0 MB"), std::string::npos) << shown;
  EXPECT_NE(shown.find("clouds go only when you say so"), std::string::npos) << shown;
  EXPECT_NE(shown.find("3 clouds, 1.5 kB; poses and descriptors stay"), std::string::npos) << shown;
  EXPECT_NE(shown.find("alpha/run/1"), std::string::npos) << shown;
  const Outcome asked = run("store let-go");
  EXPECT_EQ(asked.code, 1);
  EXPECT_NE(asked.err.find("beta/run/1"), std::string::npos) << asked.err;
  EXPECT_NE(asked.err.find("--yes does it"), std::string::npos) << asked.err;
  EXPECT_EQ(server.station.covered.size(), 2U) << "nothing went";
  expect_fault(run("store let-go --mib 0 --yes"), 2, "0");
  expect_fault(run("store let-go --mib much"), 2, "much");
  expect_fault(run("store"), 2, "headframe store has show, let-go");
  EXPECT_NE(run("store let-go --yes").out.find("gone: 3 clouds"), std::string::npos);
  EXPECT_EQ(server.station.rows[0].let_go, 2U);
  EXPECT_EQ(run("store let-go --yes").out, "no cloud may go\n");
  expect_fault(run("store let-go"), 1, "no cloud may go");
}

TEST_F(HeadframeCommand, TheServersOfTheBaseStationAreListed) {
  const std::string shown = run("servers").out;
  EXPECT_NE(shown.find("pit:/var/lib/headframe  active   0.0.0.0:7447"), std::string::npos) << shown;
  EXPECT_NE(shown.find("surface"), std::string::npos) << shown;
  EXPECT_NE(shown.find("standby"), std::string::npos) << shown;
  EXPECT_NE(shown.find("1 s ago"), std::string::npos) << shown;
  const auto json = Json::parse(run("servers --json").out);
  EXPECT_EQ(json["servers"][0]["self"], true);
  EXPECT_EQ(json["servers"][1]["role"], "standby");
  EXPECT_EQ(json["servers"][1]["relayed"], 3);
  EXPECT_EQ(json["servers"][1]["searched"], 17);
  EXPECT_EQ(json["servers"][1]["searches"], Json::array({4, 9}));
  EXPECT_EQ(json["servers"][0]["searches"], Json::array());
}

}  // namespace
}  // namespace headframe
