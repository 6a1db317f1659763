// openapi.json against the server: the routes, and the answers of each.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "server/cli/http_client.hpp"
#include "server/operator/router.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/operator_server.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

struct FewRobots : RobotAdmin {
  std::vector<RobotRow> robots() const override {
    return {{"ant", "invited", 0, 2e9, 0}, {"bee", "enrolled", 1e9, 0, 8}};
  }
  std::string fingerprint() const override { return "00"; }
  void add(const std::string&, const std::function<void(const Result<std::string>&)>& done) override { done("code"); }
  void revoke(const std::string&, const std::function<void(const Result<void>&)>& done) override { done({}); }
  void set_rate(const std::string&, std::uint64_t, const std::function<void(const Result<void>&)>& done) override {
    done({});
  }
};

struct Asked {
  std::string method, path, target, body;
  std::string name() const { return method + " " + path; }
};

class OpenApi : public testing::Test {
 protected:
  HttpResponse ask(const Asked& asked) {
    auto response = asked.method == "get"    ? client.get(asked.target)
                    : asked.method == "post" ? client.post(asked.target, asked.body)
                                             : client.remove(asked.target);
    EXPECT_TRUE(response) << asked.target << ": " << response.error().message;
    return response.value_or(HttpResponse{});
  }
  const Json& answers_of(const Asked& asked) { return api["paths"][asked.path][asked.method]["responses"]; }

  FewRobots robots;
  TempDir folder;
  std::unique_ptr<OperatorRegistry> people = *OperatorRegistry::open(folder.path() / "operators.json");
  OperatorServer server{{}, {"", &robots, {}, {}, people.get()}};
  HttpClient client{*parse_http_endpoint(server.where())};
  Json api = Json::parse(client.get("/api/v1/openapi.json")->body);
  JsonSchema schema{api};
};

TEST_F(OpenApi, NamesJustTheRoutesThereAre) {
  std::set<std::string> described, served;
  for (const auto& [path, operations] : api["paths"].items())
    for (const auto& [method, operation] : operations.items()) {
      std::string line = method;
      line.append(" ").append(path);
      std::set<std::string> parameters;
      for (const Json& parameter : operation.value("parameters", Json::array())) {
        const auto name = parameter["name"].get<std::string>();
        if (parameter["in"] == "query") parameters.insert(name);
        if (parameter["in"] == "path") {
          EXPECT_NE(path.find("{" + name + "}"), std::string::npos) << line;
        }
      }
      for (const auto& name : parameters) line.append(" ").append(name);
      described.insert(line);
    }
  for (const RouteName& route : route_names()) {
    std::string line;
    for (const char c : route.method) line += static_cast<char>(std::tolower(c));
    line.append(" ").append(route.path);
    for (const auto& name : std::set<std::string>(route.parameters.begin(), route.parameters.end()))
      line.append(" ").append(name);
    served.insert(line);
  }
  EXPECT_EQ(described, served);
}

TEST_F(OpenApi, DescribesEveryAnswerThatIsJson) {
  server.station.floor = true;
  server.station.view.alignments[0].alignment.evidence.inlier_fraction = 0.9;
  server.station.view.alignments[0].alignment.T_a_b = Pose::Identity();
  server.station.view.alignments[1].alignment.objection = Objection{1, 3, 0.1};
  server.station.view.alignments[0].alignment.T_a_b_runner_up = Pose::Identity();
  server.station.view.alignments[0].alignment.changes.push_back(
      {ChangeKind::excavated, {1, 2, 3}, 4, 3, 2, false, 1.7e9, 1.71e9});
  const std::string survey =
      R"({"points":[{"p_session":[0,0,0],"p_grid":[0,0,0]},{"p_session":[9,0,0],"p_grid":[9,0,0]},
                                           {"p_session":[0,9,0],"p_grid":[0,9,0]}]})";
  const std::vector<Asked> all{
      {"get", "/healthz", "/healthz", ""},
      {"get", "/readyz", "/readyz", ""},
      {"get", "/api/v1/openapi.json", "/api/v1/openapi.json", ""},
      {"get", "/api/v1/status", "/api/v1/status", ""},
      {"post", "/api/v1/sessions/{id}/rename", "/api/v1/sessions/2/rename?name=drift", ""},
      {"get", "/api/v1/sessions", "/api/v1/sessions", ""},
      {"get", "/api/v1/atlas", "/api/v1/atlas", ""},
      {"get", "/api/v1/atlas", "/api/v1/atlas?wait=0", ""},
      {"get", "/api/v1/alignments", "/api/v1/alignments", ""},
      {"get", "/api/v1/changes", "/api/v1/changes?since=1.7e9", ""},
      {"get", "/api/v1/log", "/api/v1/log?most=9", ""},
      {"post", "/api/v1/alignments/{id}/{decision}", "/api/v1/alignments/1/confirm", ""},
      {"get", "/api/v1/alignments/{id}/overlay", "/api/v1/alignments/1/overlay?most=20", ""},
      {"get", "/api/v1/explain", "/api/v1/explain?a=alpha&b=beta", ""},
      {"get", "/api/v1/explain", "/api/v1/explain?a=beta&b=gamma%20%223%22", ""},
      {"post", "/api/v1/place", "/api/v1/place?a=alpha&b=beta", R"({"at":[1,2,3,90]})"},
      {"get", "/api/v1/sessions/{id}/trajectory", "/api/v1/sessions/1/trajectory", ""},
      {"post", "/api/v1/sessions/{id}/anchor", "/api/v1/sessions/1/anchor", ""},
      {"post", "/api/v1/sessions/{id}/request-clouds", "/api/v1/sessions/2/request-clouds", ""},
      {"post", "/api/v1/sessions/{id}/quarantine", "/api/v1/sessions/2/quarantine?reason=loose", ""},
      {"post", "/api/v1/sessions/{id}/release", "/api/v1/sessions/2/release", ""},
      {"post", "/api/v1/sessions/{id}/archive", "/api/v1/sessions/2/archive", ""},
      {"post", "/api/v1/sessions/{id}/restore", "/api/v1/sessions/2/restore", ""},
      {"post", "/api/v1/sessions/{id}/freeze", "/api/v1/sessions/2/freeze", ""},
      {"post", "/api/v1/sessions/{id}/thaw", "/api/v1/sessions/2/thaw", ""},
      {"post", "/api/v1/sessions/{id}/note", "/api/v1/sessions/2/note?text=wet", ""},
      {"post", "/api/v1/sessions/{id}/site", "/api/v1/sessions/2/site?site=north", ""},
      {"post", "/api/v1/sites", "/api/v1/sites?robot=ant&site=north", ""},
      {"post", "/api/v1/sites", "/api/v1/sites?robot=bee", ""},
      {"get", "/api/v1/sites", "/api/v1/sites", ""},
      {"get", "/api/v1/sessions/{id}/dependents", "/api/v1/sessions/2/dependents", ""},
      {"get", "/api/v1/store", "/api/v1/store", ""},
      {"get", "/api/v1/servers", "/api/v1/servers", ""},
      {"post", "/api/v1/store/let-go", "/api/v1/store/let-go?bytes=1000", ""},
      {"post", "/api/v1/survey", "/api/v1/survey?session=1", survey},
      {"get", "/api/v1/survey", "/api/v1/survey", ""},
      {"delete", "/api/v1/survey", "/api/v1/survey?session=1", ""},
      {"post", "/api/v1/notes", "/api/v1/notes",
       R"({"kind":"note","text":"loose","places":[{"session_id":1,"p_session":[1,2,3]}]})"},
      {"get", "/api/v1/notes", "/api/v1/notes", ""},
      {"delete", "/api/v1/notes/{id}", "/api/v1/notes/1", ""},
      {"get", "/api/v1/me", "/api/v1/me", ""},
      {"post", "/api/v1/sign-in", "/api/v1/sign-in", ""},
      {"post", "/api/v1/sign-out", "/api/v1/sign-out", ""},
      {"post", "/api/v1/operators/add", "/api/v1/operators/add?name=anna&role=view&days=1", ""},
      {"get", "/api/v1/operators", "/api/v1/operators", ""},
      {"post", "/api/v1/operators/revoke", "/api/v1/operators/revoke?name=anna", ""},
      {"post", "/api/v1/merge", "/api/v1/merge", ""},
      {"get", "/api/v1/robots", "/api/v1/robots", ""},
      {"post", "/api/v1/robots/add", "/api/v1/robots/add?robot=ant", ""},
      {"post", "/api/v1/robots/rate", "/api/v1/robots/rate?robot=ant&kib_s=8", ""},
      {"post", "/api/v1/robots/revoke", "/api/v1/robots/revoke?robot=ant", ""},
      {"delete", "/api/v1/sessions/{id}", "/api/v1/sessions/3", ""}};
  std::set<std::string> asked_for, described;
  for (const Asked& asked : all) {
    asked_for.insert(asked.name());
    const HttpResponse response = ask(asked);
    const Json& answers = answers_of(asked);
    const std::string status = std::to_string(response.status);
    ASSERT_TRUE(answers.contains(status)) << asked.target << ": " << status << " " << response.body;
    const Json& wanted = answers[status]["content"]["application/json"]["schema"];
    for (const std::string& fault : schema.faults(Json::parse(response.body), wanted))
      ADD_FAILURE() << asked.method << " " << asked.target << ": " << fault;
  }
  for (const auto& [path, operations] : api["paths"].items())
    for (const auto& [method, operation] : operations.items())
      for (const auto& [status, answer] : operation["responses"].items())
        if (answer.value("content", Json::object()).contains("application/json"))
          described.insert(Asked{method, path, "", ""}.name());
  EXPECT_EQ(asked_for, described);
}

TEST_F(OpenApi, FaultsAreAsDescribed) {
  const Asked asked{"get", "/api/v1/sessions/{id}/trajectory", "/api/v1/sessions/9/trajectory", ""};
  const HttpResponse response = ask(asked);
  EXPECT_EQ(response.status, 404);
  const Json& fault = api["components"]["responses"]["Fault"]["content"]["application/json"]["schema"];
  EXPECT_EQ(schema.faults(Json::parse(response.body), fault), std::vector<std::string>{});
}

TEST_F(OpenApi, ASchemaNoticesWhatDoesNotFit) {
  const Json& session = api["components"]["schemas"]["Session"];
  Json row = Json::parse(client.get("/api/v1/sessions")->body)["sessions"][0];
  EXPECT_EQ(schema.faults(row, session), std::vector<std::string>{});
  row["keyframes"] = -1;
  row["sensor"]["beams"] = "many";
  row["colour"] = "red";
  row.erase("robot");
  EXPECT_EQ(schema.faults(row, session),
            (std::vector<std::string>{"answer lacks robot", "answer.colour is not described", "answer.keyframes is -1",
                                      "answer.sensor.beams is \"many\", no integer"}));
}

}  // namespace
}  // namespace headframe
