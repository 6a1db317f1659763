#include "tests/bench/link/hostile_trial.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/descriptor/family.hpp"
#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"
#include "server/cli/http_client.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/bench/link/seconds_since.hpp"
#include "tests/bench/link/served.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int robots = 6;
constexpr double every_s = 0.1;        // a keyframe of each robot
constexpr double merge_within_s = 60;  // else it counts as hung
// The robots that load the link are not merged: they would hide what an attack does to those that are. Nor does the
// pair wait for what they come to say, though its mine of boxes looks alike everywhere: that would hide it too.
constexpr const char* config = "[limits]\nhello_s = 2\nwrite_s = 2\n[merge]\nleast_path_m = 1e5\nlook_alikes = 1e9\n";

Result<HttpResponse> ask(const Served& server, const std::string& target) {
  auto endpoint = parse_http_endpoint(server.http);
  if (!endpoint) return tl::unexpected(endpoint.error());
  std::ifstream token(server.data / "operator.token");
  std::getline(token, endpoint->token);
  return HttpClient(*endpoint, {.connect_s = 5, .silence_s = 5}).get(target);
}

struct Loader {
  std::string name;
  std::unique_ptr<RobotClient> client;
  std::uint64_t added = 0, acknowledged = 0;
  std::vector<double> added_s;
};

/// The honest robots of one server.
class Honest {
 public:
  Honest(const Served& server, fs::path spools) : server_(server), spools_(std::move(spools)), loaders_(robots) {}

  Result<void> connect() {
    for (std::size_t i = 0; i < loaders_.size(); ++i) {
      loaders_[i].name = "robot" + std::to_string(i);
      auto client = open(drive_config(loaders_[i].name, spools_ / loaders_[i].name, "127.0.0.1", server_.port, "?"));
      if (!client) return tl::unexpected(client.error());
      loaders_[i].client = std::move(*client);
    }
    return {};
  }

  /// For so long, and until all is acknowledged; keyframe to ack in ms.
  std::vector<double> load(double seconds) {
    std::vector<double> ack_ms;
    const auto start = Clock::now();
    for (bool all = false; (since(start) < seconds || !all) && since(start) < seconds + 60;) {
      all = true;
      for (Loader& robot : loaders_) {
        const double now_s = since(start);
        if (now_s < seconds && now_s >= static_cast<double>(robot.added_s.size()) * every_s) {
          robot.added_s.push_back(now_s);
          (void)add_drive_keyframe(*robot.client, robot.name, ++robot.added);
        }
        const auto before = robot.added - robot.added_s.size();
        for (; before + robot.acknowledged < robot.client->progress().keyframes_acknowledged; ++robot.acknowledged)
          ack_ms.push_back((since(start) - robot.added_s[robot.acknowledged]) * 1e3);
        all = all && robot.acknowledged == robot.added_s.size();
      }
      std::this_thread::sleep_for(1ms);
    }
    for (Loader& robot : loaders_) {
      robot.added_s.clear();
      robot.acknowledged = 0;
    }
    return ack_ms;
  }

  /// Two robots come with drives that overlap, and go; how long until they are one component. Negative: never.
  Result<double> merge() {
    std::vector<std::unique_ptr<RobotClient>> pair;
    for (const test::Drive& drive : {test::drive_a_to_c(3), test::drive_b_to_a(3)}) {
      const std::string name = "pair" + std::to_string(pair.size());
      RobotConfig settings = drive_config(name, spools_ / name, "127.0.0.1", server_.port, "?");
      const Descriptor& any = drive.keyframes.front().descriptor;
      settings.own_descriptors =
          OwnDescriptors{make_family(default_family_name).value()->id(), any.q.size(), any.w.size()};
      auto client = open(settings);
      if (!client) return tl::unexpected(client.error());
      for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
        const Keyframe& k = drive.keyframes[i];
        const auto& points = drive.clouds[i].sweeps[0].points;
        if (auto added = (*client)->add_keyframe(k.stamp_s, k.T_local_sensor, k.descriptor, points); !added)
          return tl::unexpected(added.error());
      }
      pair.push_back(std::move(*client));
    }
    for (auto& robot : pair)
      if (auto done = robot->finish(30s); !done) return -1;
    const auto start = Clock::now();
    for (auto& robot : pair) robot->close();
    while (since(start) < merge_within_s) {
      if (together()) return since(start);
      std::this_thread::sleep_for(10ms);
    }
    return -1;
  }

  bool together() const { return together_on(server_); }
  static bool together_on(const Served& server) {
    const auto answer = ask(server, "/api/v1/atlas");
    const auto atlas = answer ? nlohmann::json::parse(answer->body, nullptr, false) : nlohmann::json();
    if (!atlas.is_object() || !atlas.contains("components")) return false;
    for (const auto& component : atlas["components"]) {
      int of_pair = 0;
      for (const auto& placed : component["sessions"])
        of_pair += placed.value("robot", std::string()).rfind("pair", 0) == 0 ? 1 : 0;
      if (of_pair == 2) return true;
    }
    return false;
  }

 private:
  Result<std::unique_ptr<RobotClient>> open(RobotConfig settings) const {
    const auto code = enrolment(server_.http, server_.data, settings.robot);
    if (!code) return tl::unexpected(code.error());
    settings.enrolment = *code;
    settings.sync = false;  // robots have disks of their own
    return RobotClient::open(settings);
  }

  const Served& server_;
  fs::path spools_;
  std::vector<Loader> loaders_;
};

/// What came of the server in the end.
std::string death_of(Served& server, const fs::path& scratch, bool merged) {
  if (const int status = server.process.poll(); status != -1) return "it died, status " + std::to_string(status);
  if (const auto alive = ask(server, "/healthz"); !alive || alive->status != 200) return "it does not answer";
  server.process.signal(SIGTERM);
  const auto ended = server.process.wait(6s);
  if (!ended) return "SIGTERM does not end it";
  if (ended->status != 0) return "it ends with status " + std::to_string(ended->status);
  const auto again = serve(scratch, config);
  if (!again) return "it does not start again";
  if (merged && !Honest::together_on(*again)) return "after a restart the honest two are apart";
  return merged ? "" : "the honest two were not merged";
}

}  // namespace

Result<Trial> hostile_trial(const Attack& attack, double seconds, const fs::path& scratch) {
  auto server = serve(scratch, config);
  if (!server) return tl::unexpected(server.error());
  Honest honest(*server, scratch / "robots");
  if (auto done = honest.connect(); !done) return tl::unexpected(done.error());
  const auto code = enrolment(server->http, server->data, "bad");
  if (!code) return tl::unexpected(code.error());
  const test::HostileTarget target{{"127.0.0.1", server->port},
                                   "robot0",
                                   "bad",
                                   random_secret(token_bytes),
                                   parse_enrolment(*code)->code,
                                   parse_http_endpoint(server->http).value()};
  test::enrol_accomplice(target);
  (void)honest.load(1);
  Trial trial;
  std::atomic<bool> stop{false};
  std::thread attacker([&] {
    (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 19);  // its work is not the server's
    while (attack.act && !stop) {
      attack.act(target);
      ++trial.acts;
      std::this_thread::sleep_for(100ms);
    }
  });
  Result<double> merge_s = -1;
  std::thread merging([&] { merge_s = honest.merge(); });
  trial.ack_ms = honest.load(seconds);
  merging.join();
  stop = true;
  if (!merge_s) trial.death = merge_s.error().message;
  trial.merge_s = merge_s.value_or(-1);
  if (trial.death.empty()) trial.death = death_of(*server, scratch, trial.merge_s >= 0);
  attacker.join();
  return trial;
}

}  // namespace headframe::bench
