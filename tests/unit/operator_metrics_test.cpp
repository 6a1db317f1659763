// What Prometheus reads, and whether the server is ready.
#include <fstream>
#include <regex>

#include "tests/support/operator_api_fixture.hpp"

namespace headframe {
namespace {

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
  EXPECT_EQ(samples["headframe_standbys"], 1);
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

}  // namespace
}  // namespace headframe
