#pragma once
// Two servers on one PostgreSQL: the first serves, the second stands by.

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>

#include "tests/support/base_station.hpp"
#include "tests/support/postgres_fixture.hpp"

namespace headframe::test {

class Servers : public PostgresFixture {
 protected:
  void SetUp() override {
    PostgresFixture::SetUp();
    std::ofstream(config()) << "[store]\nurl = \"" << url << "\"\nstandby = true\n";
  }

  std::filesystem::path folder(const std::string& name) const { return scratch.path() / name; }
  std::filesystem::path config() const { return folder("config.toml"); }

  /// The first server, and a second one that was given what robots and operators know the first by.
  void start_both(bool insecure) {
    auto active = BaseStation::start(folder("first"), "127.0.0.1:0", insecure, config());
    ASSERT_TRUE(active) << active.error().message;
    first.emplace(std::move(*active));
    std::filesystem::create_directories(folder("second"));
    for (const char* file : {"identity.pem", "operator.token"})
      if (!insecure) std::filesystem::copy_file(folder("first") / file, folder("second") / file);
    auto standby = BaseStation::start_standby(folder("second"), config(), insecure);
    ASSERT_TRUE(standby) << standby.error().message;
    second.emplace(std::move(*standby));
  }

  static nlohmann::json rows(const BaseStation& station, const std::string& what) {
    const auto ended = station.command({what, "--json"});
    EXPECT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
    const auto json = ended ? nlohmann::json::parse(ended->output, nullptr, false) : nlohmann::json();
    return json.is_object() ? json.at(what) : nlohmann::json::array();
  }

  /// By robot: how many keyframes and clouds the server has.
  static std::map<std::string, std::pair<int, int>> counts(const BaseStation& station) {
    std::map<std::string, std::pair<int, int>> out;
    for (const auto& row : rows(station, "sessions")) {
      EXPECT_FALSE(out.contains(row.at("robot"))) << "one session a robot";
      out[row.at("robot")] = {row.at("keyframes"), row.at("clouds")};
    }
    return out;
  }

  static bool lists_a_standby(const BaseStation& station) {
    const nlohmann::json servers = rows(station, "servers");
    return servers.size() == 2 && servers[0]["role"] == "active" && servers[0]["self"] == true &&
           servers[1]["role"] == "standby" && servers[1]["heard_ago_s"] < 2;
  }

  /// A robot that knows these servers, none given: both; and is enrolled at the first.
  Result<Process> drive(const std::string& robot, const std::string& rate, std::vector<std::string> servers = {},
                        const std::string& linger_s = "5") {
    if (servers.empty()) servers = {first->robots(), second->robots()};
    std::vector<std::string> argv{program("headframe-replay"), "--robot", robot, "--rate", rate, "--linger", linger_s};
    for (const std::string& server : servers) argv.insert(argv.end(), {"--server", server});
    const auto admission = first->admission(robot);
    if (!admission) return tl::unexpected(admission.error());
    argv.insert(argv.end(), admission->begin(), admission->end());
    argv.push_back(folder(robot).string());
    return Process::start(argv);
  }

  static void expect_done(Process& replay) {
    const auto ended = replay.wait(std::chrono::seconds(120));
    ASSERT_TRUE(ended) << ended.error().message;
    EXPECT_EQ(ended->status, 0) << ended->output;
  }

  /// Asks until it holds: nothing here waits for a time, only for a state.
  static bool until(const std::function<bool()>& holds) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < deadline)
      if (holds()) return true;
    return false;
  }

  void cut_off_who_has_the_database() {
    EXPECT_TRUE(
        cluster->execute("SELECT pg_terminate_backend(pid) FROM pg_locks WHERE locktype = 'advisory' AND granted"));
  }

  std::optional<BaseStation> first, second;
};

}  // namespace headframe::test
