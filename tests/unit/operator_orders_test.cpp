// What operators decide, over the API.
#include "tests/support/operator_api_fixture.hpp"

namespace headframe {
namespace {

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

}  // namespace
}  // namespace headframe
