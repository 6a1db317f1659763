// An operator changes what a robot may send while it is connected.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/robot_client.hpp"
#include "server/cli/http_client.hpp"
#include "server/map_merge_server.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

class RobotRate : public testing::Test {
 protected:
  void serve(const Endpoint& robots) {
    server_.reset();
    ServerConfig config;
    config.limits.uplink_kib_s = 100;
    ServerOptions options;
    options.data = folder_.path() / "data";
    options.listen = robots;
    options.http = Endpoint{"127.0.0.1", 0};
    options.config = config;
    auto started = MapMergeServer::start(options);
    ASSERT_TRUE(started) << started.error().message;
    server_ = std::move(*started);
  }

  HttpResponse post(const std::string& target) const {
    auto http = parse_http_endpoint(to_string(server_->http())).value();
    std::ifstream token(folder_.path() / "data" / "operator.token");
    std::getline(token, http.token);
    const auto response = HttpClient(http).post(target);
    EXPECT_TRUE(response) << response.error().message;
    return response.value_or(HttpResponse{});
  }

  Result<std::unique_ptr<RobotClient>> robot() const {
    RobotConfig config;
    config.robot = "ant";
    config.spool = folder_.path() / "spool";
    config.host = server_->robots().host;
    config.port = server_->robots().port;
    config.enrolment = nlohmann::json::parse(post("/api/v1/robots/add?robot=ant").body).at("enrolment");
    return RobotClient::open(config);
  }

  /// Waits up to ten seconds for it.
  static bool is_told(const RobotClient& robot, double kib_s) {
    for (int i = 0; i < 1000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(10)))
      if (robot.progress().connected && robot.progress().server_bytes_per_s == kib_s * 1024) return true;
    return false;
  }

  TempDir folder_;
  std::unique_ptr<MapMergeServer> server_;
};

TEST_F(RobotRate, TakesEffectOnALiveConnectionAndOutlivesTheServer) {
  serve({"127.0.0.1", 0});
  const auto ant = robot();
  ASSERT_TRUE(ant) << ant.error().message;
  EXPECT_TRUE(is_told(**ant, 100)) << "the share of all";
  EXPECT_EQ(post("/api/v1/robots/rate?robot=ant&kib_s=16").status, 200);
  EXPECT_TRUE(is_told(**ant, 16));
  EXPECT_EQ(post("/api/v1/robots/rate?robot=ant&kib_s=500").status, 200);
  EXPECT_TRUE(is_told(**ant, 100)) << "the smaller counts";
  EXPECT_EQ(post("/api/v1/robots/rate?robot=ant&kib_s=8").status, 200);
  EXPECT_EQ((*ant)->progress().link_error, "") << "the connection stayed";
  const Endpoint robots = server_->robots();
  serve(robots);
  EXPECT_TRUE(is_told(**ant, 8)) << "after a restart";
  EXPECT_EQ(post("/api/v1/robots/rate?robot=ant&kib_s=0").status, 200);
  EXPECT_TRUE(is_told(**ant, 100));

  EXPECT_EQ(post("/api/v1/robots/rate?robot=bee&kib_s=8").status, 404);
  for (const std::string bad : {"", "&kib_s=", "&kib_s=-1", "&kib_s=x", "&kib_s=2000000"})
    EXPECT_EQ(post("/api/v1/robots/rate?robot=ant" + bad).status, 400) << bad;
}

}  // namespace
}  // namespace headframe
