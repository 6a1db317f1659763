#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "server/cli/http_client.hpp"
#include "tests/support/operator_server.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

class OperatorApiTest : public testing::Test {
 protected:
  HttpResponse get(const std::string& target) { return taken(client.get(target)); }
  HttpResponse post(const std::string& target) { return taken(client.post(target)); }
  static HttpResponse taken(Result<HttpResponse> response) {
    EXPECT_TRUE(response) << response.error().message;
    return response.value_or(HttpResponse{});
  }
  void expect_error(const HttpResponse& response, int status, const std::string& code, const std::string& says) {
    EXPECT_EQ(response.status, status);
    const Json json = Json::parse(response.body);
    EXPECT_EQ(json["error"]["code"], code);
    EXPECT_NE(json["error"]["message"].get<std::string>().find(says), std::string::npos) << response.body;
  }

  OperatorServer server;
  HttpClient client{*parse_http_endpoint(server.where())};
};

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

/// "headframe_..." names of a text.
std::set<std::string> metrics_named_in(const std::string& text) {
  static const std::regex name("headframe_[a-z_]+");
  return {std::sregex_token_iterator(text.begin(), text.end(), name), {}};
}

TEST_F(OperatorApiTest, EveryMetricOfTheDashboardIsServed) {
  std::ifstream file(HEADFRAME_SOURCE_DIR "/docker/grafana/headframe.json");
  const Json dashboard = Json::parse(file);
  const std::set<std::string> served = metrics_named_in(get("/metrics").body);
  std::set<std::string> asked;
  for (const Json& panel : dashboard["panels"])
    for (const Json& target : panel["targets"]) asked.merge(metrics_named_in(target["expr"].get<std::string>()));
  EXPECT_GT(asked.size(), 15U);
  for (const std::string& name : asked) EXPECT_TRUE(served.contains(name)) << name;
}

TEST_F(OperatorApiTest, AlertsAskForMetricsThatThereAre) {
  std::ifstream file(HEADFRAME_SOURCE_DIR "/docker/prometheus/headframe.rules.yml");
  std::set<std::string> asked;
  const std::set<std::string> served = metrics_named_in(get("/metrics").body);
  for (std::string line; std::getline(file, line);)
    if (const auto at = line.find("expr: "); at != std::string::npos)
      asked.merge(metrics_named_in(line.substr(at + 6)));
  EXPECT_GT(asked.size(), 7U);
  for (const std::string& name : asked) EXPECT_TRUE(served.contains(name)) << name;
}

TEST_F(OperatorApiTest, MetricsAreWhatPrometheusReads) {
  server.station.work.effort.attempts = 5;
  server.station.work.effort.withdrawn = 2;
  server.station.work.effort.stages.registration_ms = 1500;
  server.station.work.commits = 4;
  server.station.work.commit_s = 0.25;
  server.station.rows[1].backlog = 9;
  server.station.rows[1].cloud_bytes = 600;
  const HttpResponse response = get("/metrics");
  EXPECT_EQ(response.status, 200);
  std::istringstream lines(response.body);
  std::map<std::string, double> samples;
  std::set<std::string> described;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("# TYPE ", 0) == 0) described.insert(line.substr(7, line.find(' ', 7) - 7));
    if (line.empty() || line[0] == '#') continue;
    const std::size_t space = line.rfind(' ');
    EXPECT_TRUE(samples.emplace(line.substr(0, space), std::stod(line.substr(space + 1))).second) << line;
    EXPECT_TRUE(described.contains(line.substr(0, line.find_first_of("{ ")))) << line;
  }
  EXPECT_EQ(samples["headframe_robots_connected"], 2);
  EXPECT_EQ(samples["headframe_keyframes"], 9);
  EXPECT_EQ(samples["headframe_alignments{state=\"published\"}"], 1);
  EXPECT_EQ(samples["headframe_alignments{state=\"candidate\"}"], 0);
  EXPECT_EQ(samples["headframe_verdicts{verdict=\"candidate\"}"], 2);
  EXPECT_EQ(samples["headframe_backlog_keyframes"], 9);
  EXPECT_EQ(samples["headframe_robot_bytes_received_total{kind=\"clouds\"}"], 600);
  EXPECT_EQ(samples["headframe_robot_bytes_received_total{kind=\"keyframes_and_control\"}"], 2400);
  EXPECT_EQ(samples["headframe_store_commits_total"], 4);
  EXPECT_EQ(samples["headframe_store_commit_seconds_total"], 0.25);
  EXPECT_EQ(samples["headframe_merge_attempts_total"], 5);
  EXPECT_EQ(samples["headframe_merges_withdrawn_total"], 2);
  EXPECT_EQ(samples["headframe_merge_seconds_total{stage=\"registration\"}"], 1.5);
}

TEST_F(OperatorApiTest, IsReadyUnlessTheDiskRefuses) {
  EXPECT_EQ(get("/readyz").status, 200);
  server.station.change([&] { server.station.work.disk_error = "disk is full"; });
  expect_error(get("/readyz"), 503, "unavailable", "disk is full");
  server.station.change([&] {
    server.station.work = {};
    server.station.work.merge_work_s = 130;
    server.station.work.merge_stuck = "merging is stuck: say why";
  });
  expect_error(get("/readyz"), 503, "unavailable", "merging is stuck");
  EXPECT_NE(get("/metrics").body.find("headframe_merge_work_seconds 130\n"), std::string::npos);
  EXPECT_NE(get("/metrics").body.find("headframe_merge_stuck 1\n"), std::string::npos);
  EXPECT_EQ(get("/healthz").status, 200) << "alive all the same";
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
  EXPECT_EQ(atlas.size(), 3U) << "nothing else without wait";
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
  EXPECT_EQ(atlas["alignments"][1]["state"], "rejected");
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

TEST_F(OperatorApiTest, DecisionsReachTheStationAndAnswerWithTheAlignment) {
  const Json before = Json::parse(get("/api/v1/alignments").body);
  ASSERT_EQ(before["alignments"].size(), 2U);
  EXPECT_EQ(before["alignments"][1]["id"], 2);
  EXPECT_EQ(before["alignments"][1]["decision"], "none");
  const HttpResponse confirmed = post("/api/v1/alignments/2/confirm");
  EXPECT_EQ(confirmed.status, 200);
  const Json json = Json::parse(confirmed.body);
  EXPECT_EQ(json["alignment"]["state"], "published");
  EXPECT_EQ(json["alignment"]["decision"], "confirmed");
  EXPECT_EQ(json["revision"], 7);
  for (const char* name : {"refuse", "retract", "undo"})
    EXPECT_EQ(post(std::string("/api/v1/alignments/1/") + name).status, 200);
  EXPECT_EQ(server.station.decided.size(), 4U);
  EXPECT_EQ(server.station.decided.back(), std::pair(AlignmentId{1}, Decision::undo));
  expect_error(post("/api/v1/alignments/9/confirm"), 404, "not_found", "no such alignment");
  expect_error(post("/api/v1/alignments/1x/confirm"), 400, "invalid_argument", "1x");
  expect_error(post("/api/v1/alignments/1/approve"), 404, "not_found", "approve");
  expect_error(post("/api/v1/alignments/1"), 404, "not_found", "nothing at");
  expect_error(post("/api/v1/alignments//confirm"), 404, "not_found", "nothing at");
  expect_error(get("/api/v1/alignments/1/confirm"), 405, "refused", "POST");
}

TEST_F(OperatorApiTest, SessionsGetLabelsAnchorsAndCloudRequests) {
  EXPECT_TRUE(Json::parse(get("/api/v1/sessions").body)["sessions"][1]["label"].is_null());
  const HttpResponse renamed = post("/api/v1/sessions/2/rename?name=north+drift");
  EXPECT_EQ(renamed.status, 200);
  EXPECT_EQ(Json::parse(renamed.body)["label"], "north drift");
  EXPECT_EQ(Json::parse(renamed.body)["component"], 1);
  EXPECT_EQ(Json::parse(get("/api/v1/sessions").body)["sessions"][1]["label"], "north drift");
  const Json placed = Json::parse(get("/api/v1/atlas").body)["components"][0]["sessions"];
  EXPECT_EQ(placed[1]["label"], "north drift");
  EXPECT_EQ(placed[1]["id"], 2);
  EXPECT_EQ(post("/api/v1/sessions/2/rename?name=").status, 200);
  EXPECT_TRUE(Json::parse(get("/api/v1/sessions").body)["sessions"][1]["label"].is_null());
  expect_error(post("/api/v1/sessions/2/rename"), 400, "invalid_argument", "\"name\" is missing");
  expect_error(post("/api/v1/sessions/9/rename?name=x"), 404, "not_found", "no session 9");

  const Json anchored = Json::parse(post("/api/v1/sessions/2/anchor").body);
  EXPECT_EQ(anchored, (Json{{"revision", 7}, {"component", 1}}));
  EXPECT_EQ(server.station.anchored, std::vector<SessionId>{2});
  expect_error(post("/api/v1/sessions/2x/anchor"), 404, "not_found", "no session 2x");

  const HttpResponse asked = post("/api/v1/sessions/2/request-clouds");
  EXPECT_EQ(asked.status, 202);
  EXPECT_EQ(Json::parse(asked.body)["requested"], 1);
  expect_error(post("/api/v1/sessions/1/request-clouds"), 409, "refused", "away");
  expect_error(post("/api/v1/sessions/9/request-clouds"), 404, "not_found", "no session 9");
}

TEST_F(OperatorApiTest, ASurveyIsSetSeenAndTakenAway) {
  EXPECT_EQ(Json::parse(get("/api/v1/survey").body)["surveys"], Json::array());
  // Session 2 lies turned by 90 deg in the grid; component 1 has it turned by 90 deg too, at (10, 20, 30).
  const Json points{{{"name", "A"}, {"p_session", {0, 0, 0}}, {"p_grid", {1000000, 2000000, 100}}},
                    {{"name", "B"}, {"p_session", {50, 0, 0}}, {"p_grid", {1000000, 2000050, 100}}},
                    {{"p_session", {0, 50, 0}}, {"p_grid", {999950, 2000000, 100}}}};
  const HttpResponse set = taken(client.post("/api/v1/survey?session=2", Json{{"points", points}}.dump()));
  ASSERT_EQ(set.status, 200) << set.body;
  const Json survey = Json::parse(set.body);
  const std::vector<double> wanted{0, -1, 0, 1000000, 1, 0, 0, 2000000, 0, 0, 1, 100, 0, 0, 0, 1};
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(survey["T_grid_session"][i].get<double>(), wanted[i], 1e-6) << i;
  EXPECT_EQ(survey["points"][1]["name"], "B");
  EXPECT_EQ(survey["points"][2]["name"], "point 3");
  EXPECT_NEAR(survey["points"][2]["residual_m"].get<double>(), 0, 1e-6);
  EXPECT_NEAR(survey["rms_m"].get<double>(), 0, 1e-6);
  EXPECT_EQ(survey["component"], 1);
  EXPECT_NEAR(survey["T_grid_component"][3].get<double>(), 999990, 1e-6);
  EXPECT_EQ(Json::parse(get("/api/v1/survey").body)["surveys"][0], survey);
  EXPECT_EQ(taken(client.remove("/api/v1/survey?session=2")).status, 200);
  expect_error(taken(client.remove("/api/v1/survey?session=2")), 404, "not_found", "no survey");
  EXPECT_EQ(taken(client.post("/api/v1/survey?session=1", Json{{"T_grid_session", wanted}}.dump())).status, 200);
  const HttpResponse refusal = taken(client.remove("/api/v1/atlas"));
  expect_error(refusal, 405, "refused", "takes GET");
  const auto wrong = [&](const std::string& body, const std::string& says) {
    expect_error(taken(client.post("/api/v1/survey?session=1", body)), 400, "bad_input", says);
  };
  wrong("", "no JSON object");
  wrong("{}", "one of T_grid_session and points");
  wrong(R"({"points":[],"T_grid_session":[]})", "one of T_grid_session and points");
  wrong(R"({"T_grid_session":[1,2,3]})", "16 numbers");
  wrong(R"({"points":{}})", "no list");
  wrong(R"({"points":[7]})", "point 1 is no object");
  wrong(R"({"points":[{"p_session":[0,0,0],"p_grid":[0,0,"x"]}]})", "point 1 needs");
  wrong(R"({"points":[{"name":5,"p_session":[0,0,0],"p_grid":[0,0,0]}]})", "name");
  wrong(R"({"points":[]})", "0 points");
  expect_error(post("/api/v1/survey"), 400, "invalid_argument", "\"session\" is missing");
  expect_error(post("/api/v1/survey?session=9"), 404, "not_found", "no session 9");
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
