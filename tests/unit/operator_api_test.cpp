// What the operator API answers.
#include <cstring>

#include "tests/support/operator_api_fixture.hpp"

namespace headframe {
namespace {

TEST_F(OperatorApiTest, SaysThatItIsThere) {
  EXPECT_EQ(get("/healthz").status, 200);
  const Json status = Json::parse(get("/api/v1/status").body);
  EXPECT_EQ(status["revision"], 7);
  EXPECT_EQ(status["sessions"], 3);
  EXPECT_EQ(status["connected"], 2);
  EXPECT_EQ(status["components"], 2);
  EXPECT_EQ(status["keyframes"], 9);
  EXPECT_EQ(status["clouds"], 6);
  EXPECT_EQ(status["bytes_received"], 3000);
  EXPECT_EQ(status["alignments"], (Json{{"published", 1}, {"rejected", 1}}));
  EXPECT_EQ(status["pending"], (Json{{"attempts", 0}, {"keyframes", 0}, {"awaited_submaps", 0}}));
}

TEST_F(OperatorApiTest, HasAPageOrSaysThatItHasNone) {
  const HttpResponse page = get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_FALSE(page.body.empty());
  expect_error(get("/no-such-file.js"), 404, "not_found", "nothing at");
}

TEST_F(OperatorApiTest, PointsAndPathOfASession) {
  EXPECT_EQ(get("/api/v1/sessions/1/points?level=4").body.size(), 2 * 20 + 6U * 11);
  EXPECT_EQ(get("/api/v1/sessions/1/points?level=4&from=1").body.size(), 20 + 6U);
  const Json path = Json::parse(get("/api/v1/sessions/2/trajectory?from=2").body);
  ASSERT_EQ(path["keyframes"].size(), 2U);
  EXPECT_EQ(path["keyframes"][0].size(), path["columns"].size());
  EXPECT_EQ(path["keyframes"][0][1], 201.0);
  const auto sequences = [&](const std::string& query) {
    std::vector<int> out;
    const Json found = Json::parse(get("/api/v1/sessions/2/trajectory" + query).body);
    for (const Json& row : found["keyframes"]) out.push_back(row[0]);
    return out;
  };
  EXPECT_EQ(sequences("?tolerance=0"), (std::vector{1, 2, 3}));
  EXPECT_EQ(sequences("?tolerance=100"), (std::vector{1, 3}));
  EXPECT_EQ(sequences("?from=2&tolerance=100"), (std::vector{2, 3})) << "the first that was asked for stays";
  expect_error(get("/api/v1/sessions/7/points"), 404, "not_found", "no session 7");
  expect_error(get("/api/v1/sessions/1x/trajectory"), 404, "not_found", "no session 1x");
  expect_error(get("/api/v1/sessions/1/points?level=5"), 400, "invalid_argument", "from 0 to 4");
}

TEST_F(OperatorApiTest, TheOverviewIsTheSnapshotThenPathAndPointsOfEverySession) {
  const std::string body = get("/api/v1/overview?level=4&most=1000").body;
  std::vector<std::string> parts;
  for (std::size_t at = 0; at + 4 <= body.size();) {
    std::uint32_t bytes = 0;
    std::memcpy(&bytes, body.data() + at, sizeof bytes);
    ASSERT_LE(at + 4 + bytes, body.size());
    parts.push_back(body.substr(at + 4, bytes));
    at += 4 + bytes;
  }
  ASSERT_FALSE(parts.empty());
  const Json snapshot = Json::parse(parts[0]);
  EXPECT_EQ(snapshot["type"], "snapshot");
  EXPECT_EQ(snapshot["atlas"]["revision"], Json::parse(get("/api/v1/atlas").body)["revision"]);
  const Json& rows = snapshot["sessions"]["sessions"];
  ASSERT_EQ(parts.size(), 1 + 2 * rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string session = "/api/v1/sessions/" + rows[i]["id"].dump();
    EXPECT_EQ(parts[1 + 2 * i], get(session + "/trajectory").body);
    EXPECT_EQ(parts[2 + 2 * i], get(session + "/points?level=4").body);
  }
  EXPECT_LT(get("/api/v1/overview?level=4&most=1").body.size(), body.size());
  for (const char* tolerance : {"-1", "x", "1e9"})
    expect_error(get(std::string("/api/v1/overview?tolerance=") + tolerance), 400, "invalid_argument", "tolerance");
  expect_error(get("/api/v1/overview?level=5"), 400, "invalid_argument", "from 0 to 4");
  server.station.broken_trajectory = true;
  EXPECT_FALSE(client.get("/api/v1/overview")) << "a body that ends before its end";
}

TEST_F(OperatorApiTest, SessionsCarryTheirComponent) {
  const Json rows = Json::parse(get("/api/v1/sessions").body)["sessions"];
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1]["robot"], "beta");
  EXPECT_EQ(rows[1]["session"], "run/1");
  EXPECT_EQ(rows[1]["component"], 1);
  EXPECT_EQ(rows[1]["family"], (Json{{"name", "scan_context"}, {"version", 1}}));
  EXPECT_EQ(rows[1]["sensor"]["beams"], 16);
  EXPECT_EQ(rows[1]["distance_m"], 12.5);
  EXPECT_EQ(rows[1]["trigger_to_transform_ms"], 420);
  EXPECT_TRUE(rows[2]["trigger_to_transform_ms"].is_null());
  EXPECT_EQ(rows[2]["robot"], "gamma \"3\"");
  EXPECT_EQ(rows[0]["complete"], true);
  EXPECT_EQ(rows[0]["connected"], false);
}

TEST_F(OperatorApiTest, AtlasHasTheSchemaOfItsContract) {
  const Json atlas = Json::parse(get("/api/v1/atlas").body);
  EXPECT_EQ(atlas.size(), 4U) << "nothing else without wait";
  EXPECT_EQ(atlas["revision"], 7);
  ASSERT_EQ(atlas["components"].size(), 2U);
  const Json& merged = atlas["components"][0];
  EXPECT_EQ(merged["id"], 1);
  EXPECT_EQ(merged["anchor"], (Json{{"robot", "alpha"}, {"session", "run/1"}}));
  EXPECT_EQ(merged["sessions"][1]["robot"], "beta");
  const auto T = merged["sessions"][1]["T_component_session"].get<std::vector<double>>();
  ASSERT_EQ(T.size(), 16U);
  const std::vector<double> row_major{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(T[i], row_major[i], 1e-12) << i;
  const Json& published = atlas["alignments"][0];
  EXPECT_EQ(published["a"], (Json{{"robot", "alpha"}, {"session", "run/1"}}));
  EXPECT_EQ(published["b"], (Json{{"robot", "beta"}, {"session", "run/1"}}));
  EXPECT_EQ(published["state"], "published");
  EXPECT_EQ(published["T_a_b"].size(), 16U);
  EXPECT_EQ(published["evidence"].size(), evidence_fields().size());
  EXPECT_EQ(published["evidence"]["probability"], 0.97);
  EXPECT_TRUE(published["evidence"]["tilt_deg"].is_null()) << "NaN";
  EXPECT_EQ(atlas["alignments"].size(), 1U) << "of what came to nothing only how much there is";
  EXPECT_EQ(atlas["rejected"], 1);
}

TEST_F(OperatorApiTest, AlignmentsAreAllOrThoseInOneState) {
  EXPECT_EQ(Json::parse(get("/api/v1/alignments").body)["alignments"].size(), 2U);
  const Json rejected = Json::parse(get("/api/v1/alignments?state=rejected").body)["alignments"];
  ASSERT_EQ(rejected.size(), 1U);
  EXPECT_EQ(rejected[0]["state"], "rejected");
  EXPECT_TRUE(Json::parse(get("/api/v1/alignments?state=verified").body)["alignments"].empty());
  EXPECT_EQ(get("/api/v1/alignments?state=good").status, 400);
  const Json second = Json::parse(get("/api/v1/alignments?id=2").body)["alignments"];
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0]["id"], 2);
  EXPECT_TRUE(Json::parse(get("/api/v1/alignments?id=9").body)["alignments"].empty());
  EXPECT_EQ(get("/api/v1/alignments?id=two").status, 400);
}

TEST_F(OperatorApiTest, OfPairsThatCameToNothingTheNewestAreSent) {
  server.station.change([&] {
    std::vector<AlignmentRow>& rows = server.station.view.alignments;  // 1 is published, 2 was rejected
    AlignmentRow rejected = rows[1];
    rows[1].alignment.ruling = Ruling::refused;
    for (rejected.alignment.id = 3; rejected.alignment.id <= 2000; ++rejected.alignment.id) rows.push_back(rejected);
  });
  const auto ids = [&](const std::string& query, std::size_t left_out) {
    const Json answer = Json::parse(get("/api/v1/alignments" + query).body);
    EXPECT_EQ(answer["left_out"], left_out) << query;
    std::vector<AlignmentId> out;
    for (const Json& row : answer["alignments"]) out.push_back(row["id"]);
    return out;
  };
  using Ids = std::vector<AlignmentId>;
  EXPECT_EQ(ids("?most=0", 1998), (Ids{1, 2})) << "what an operator refused is no pair that came to nothing";
  EXPECT_EQ(ids("?most=2", 1996), (Ids{1, 2, 1999, 2000}));
  EXPECT_EQ(ids("?most=1&state=rejected", 1997), (Ids{2, 2000}));
  EXPECT_EQ(ids("", 998).size(), 1002U);
  EXPECT_EQ(ids("?most=1998", 0).size(), 2000U);
  EXPECT_EQ(ids("?id=3", 0), Ids{3}) << "however old";
  EXPECT_EQ(get("/api/v1/alignments?most=-1").status, 400);
  const Json atlas = Json::parse(get("/api/v1/atlas").body);
  EXPECT_EQ(atlas["alignments"].size(), 2U);
  EXPECT_EQ(atlas["rejected"], 1998);
}

TEST_F(OperatorApiTest, NamesThatAreNoUtf8AreStillShown) {
  server.station.rows[0].key.robot = "a\xff\n";
  const Json json = Json::parse(get("/api/v1/sessions").body);
  EXPECT_EQ(json["sessions"][0]["robot"], "a\xEF\xBF\xBD\n");
}

TEST_F(OperatorApiTest, WaitEndsAsSoonAsNothingIsPending) {
  Json atlas = Json::parse(get("/api/v1/atlas?wait=3600").body);
  EXPECT_EQ(atlas["waited_out"], false);
  EXPECT_EQ(atlas["pending"]["attempts"], 0);

  server.station.set_pending({1, 2, 3});
  std::jthread settle([&] {
    while (server.station.waits < 2) std::this_thread::yield();
    server.station.set_pending({});
  });
  atlas = Json::parse(get("/api/v1/atlas?wait=3600").body);
  EXPECT_EQ(atlas["waited_out"], false);
  EXPECT_EQ(atlas["revision"], 7);
}

TEST_F(OperatorApiTest, WaitThatRunsOutSaysWhatIsPending) {
  server.station.set_pending({1, 2, 3});
  for (const char* target : {"/api/v1/atlas?wait=0", "/api/v1/atlas?wait=0.01"}) {
    const Json atlas = Json::parse(get(target).body);
    EXPECT_EQ(atlas["waited_out"], true);
    EXPECT_EQ(atlas["pending"], (Json{{"attempts", 1}, {"keyframes", 2}, {"awaited_submaps", 3}}));
    EXPECT_EQ(atlas["revision"], 7);
  }
}

TEST_F(OperatorApiTest, MergeIsQueued) {
  EXPECT_EQ(post("/api/v1/merge").status, 202);
  EXPECT_EQ(server.station.merges, 1);
}

TEST_F(OperatorApiTest, WrongRequestsGetOneClearLine) {
  expect_error(get("/api/v1/nothing"), 404, "not_found", "/api/v1/nothing");
  expect_error(get("/api"), 404, "not_found", "/api/v1/");
  expect_error(get("/api/v1/merge"), 405, "refused", "POST");
  expect_error(post("/api/v1/atlas"), 405, "refused", "GET");
  EXPECT_EQ(server.station.merges, 0);
  for (const char* wait : {"-1", "3601", "abc", "", "nan", "1e999", "5s"})
    expect_error(get(std::string("/api/v1/atlas?wait=") + wait), 400, "invalid_argument", "wait");
  expect_error(get("/api/v1/atlas?wiat=1"), 400, "invalid_argument", "wiat");
  expect_error(get("/api/v1/atlas?wait=1&wait=2"), 400, "bad_input", "twice");
  expect_error(get("/api/v1/atlas?wait=%2"), 400, "bad_input", "%XX");
  expect_error(get("/api/v1/export"), 400, "invalid_argument", "component");
  expect_error(get("/api/v1/export?component=one"), 400, "invalid_argument", "one");
  expect_error(get("/api/v1/export?component=2"), 404, "not_found", "there are 1, 3");
  expect_error(get("/api/v1/export?component=1&format=stl"), 400, "invalid_argument", "ply, pcd or las");
  for (const char* voxel : {"0.009", "101", "-1", "x"})
    expect_error(get(std::string("/api/v1/export?component=1&voxel=") + voxel), 400, "invalid_argument", "voxel");
  for (const char* voxel : {"0", "0.01", "100"})
    EXPECT_EQ(get(std::string("/api/v1/export?component=1&voxel=") + voxel).status, 200);
  expect_error(get("/api/v1/trajectory?robot=alpha"), 400, "invalid_argument", "session");
  expect_error(get("/api/v1/trajectory?robot=alpha&session=2"), 404, "not_found", "alpha/2");
}

TEST_F(OperatorApiTest, OverlayShowsBothSessionsAndHowFarTheyAreApart) {
  expect_error(get("/api/v1/alignments/2/overlay"), 404, "not_found", "nothing fitted");
  expect_error(get("/api/v1/alignments/9/overlay"), 404, "not_found", "no alignment 9");
  expect_error(get("/api/v1/alignments/1x/overlay"), 400, "invalid_argument", "1x");
  // The floor of session 1 at z = 0; that of session 2, laid on it, 5 cm higher.
  Alignment& alignment = server.station.view.alignments[0].alignment;
  alignment.evidence.inlier_fraction = 0.9;
  alignment.T_a_b = Pose(Eigen::Translation3d(0, 0, 0.05));
  server.station.floor = true;
  const Json overlay = Json::parse(get("/api/v1/alignments/1/overlay").body);
  EXPECT_TRUE(overlay["runner_up"].is_null());
  EXPECT_GT(overlay["a"].size(), 1000U);
  EXPECT_NEAR(overlay["a"][0][2].get<double>(), 0, 1e-9);
  EXPECT_NEAR(overlay["b"][0][2].get<double>(), 0.05, 1e-9);
  EXPECT_NEAR(overlay["bin_m"].get<double>(), 0.02, 1e-12);
  const auto counts = overlay["residuals_m"].get<std::vector<std::uint64_t>>();
  EXPECT_GT(counts.at(2), 1000U) << "from 4 to 6 cm";
  for (std::size_t i = 0; i < counts.size(); ++i) EXPECT_TRUE(i == 2 || counts[i] == 0) << i;
  EXPECT_EQ(overlay["unmatched"], 0);
  alignment.T_a_b_runner_up = pose_from_yaw(0, {3, 4, 5});
  alignment.evidence.runner_up = 0.25;
  const Json few = Json::parse(get("/api/v1/alignments/1/overlay?most=50").body);
  EXPECT_LE(few["a"].size(), 50U);
  EXPECT_GT(few["a"].size(), 10U);
  EXPECT_EQ(few["runner_up"]["probability"], 0.25);
  EXPECT_EQ(few["runner_up"]["T_a_b"][7], 4);
  EXPECT_EQ(few["residuals_m"], overlay["residuals_m"]) << "of all points, however few are shown";
  expect_error(get("/api/v1/alignments/1/overlay?most=100001"), 400, "invalid_argument", "from 0 to 100000");
}

TEST_F(OperatorApiTest, PlanIsAPictureOfTheComponent) {
  server.station.floor = true;
  const HttpResponse plan = get("/api/v1/plan?component=1");
  ASSERT_EQ(plan.status, 200);
  EXPECT_EQ(plan.body.substr(1, 3), "PNG");
  EXPECT_EQ(get("/api/v1/plan?component=1").body, plan.body) << "the same again";
  expect_error(get("/api/v1/plan?component=2"), 404, "not_found", "there are 1, 3");
  expect_error(get("/api/v1/plan?component=1&frame=grid"), 404, "not_found", "surveyed");
  expect_error(get("/api/v1/plan?component=1&frame=moon"), 400, "invalid_argument", "component or grid");
  server.station.surveyed = {{2, pose_from_yaw(0.3, {431250, 6212400, -300}), {}}};
  EXPECT_EQ(get("/api/v1/plan?component=1&frame=grid").body.substr(1, 3), "PNG");
}

TEST_F(OperatorApiTest, ExplainsPairsOfSessions) {
  server.station.view.alignments[0].alignment.evidence.inlier_fraction = 0.9;
  const Json merged = Json::parse(get("/api/v1/explain?a=beta&b=alpha%2Frun%2F1").body);
  EXPECT_EQ(merged["a"]["robot"], "alpha") << "in the order of the sessions";
  EXPECT_NE(merged["outcome"].get<std::string>().find("are merged: at x 10.0"), std::string::npos);
  EXPECT_EQ(merged["alignment"]["id"], 1);
  EXPECT_FALSE(merged["findings"].empty());
  const Json untried = Json::parse(get("/api/v1/explain?a=beta&b=gamma+%223%22").body);
  EXPECT_TRUE(untried["alignment"].is_null());
  expect_error(get("/api/v1/explain?a=beta"), 400, "invalid_argument", "\"b\" is missing");
  expect_error(get("/api/v1/explain?a=beta&b=beta"), 400, "invalid_argument", "name two");
  expect_error(get("/api/v1/explain?a=beta&b=delta"), 404, "not_found", "there are alpha/run/1, beta/run/1");
}

TEST_F(OperatorApiTest, TrajectoryIsInTheComponentsFrame) {
  const HttpResponse response = get("/api/v1/trajectory?robot=beta&session=run%2F1");
  EXPECT_EQ(response.status, 200);
  std::istringstream text(response.body);
  std::string comment;
  std::getline(text, comment);
  EXPECT_EQ(comment.substr(0, 1), "#");
  EXPECT_NE(comment.find("component 1"), std::string::npos);
  std::vector<double> numbers{std::istream_iterator<double>(text), {}};
  ASSERT_EQ(numbers.size(), 3U * 8);
  const double half = std::sqrt(0.5);
  const std::vector<double> second{201, 10, 21, 30, 0, 0, half, half};  // T_1_2 turns x to y
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(numbers[8 + i], second[i], 1e-6) << i;
  const std::string csv = get("/api/v1/trajectory?robot=beta&session=run%2F1&format=csv").body;
  EXPECT_EQ(csv.rfind("stamp_s,x_m,y_m,z_m,qx,qy,qz,qw\n200.000000,10.000000,20.000000,30.000000,0", 0), 0U) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  expect_error(get("/api/v1/trajectory?robot=beta&session=run%2F1&format=kml"), 400, "invalid_argument", "tum or csv");
  server.station.broken_trajectory = true;
  expect_error(get("/api/v1/trajectory?robot=beta&session=run%2F1"), 500, "bad_input", "damaged");
}

}  // namespace
}  // namespace headframe
