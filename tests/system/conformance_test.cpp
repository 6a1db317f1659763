// headframe-conformance: honest clients pass, and each planted fault is found and called by its name.

#include <gtest/gtest.h>

#include <atomic>
#include <sstream>
#include <thread>

#include "tests/support/base_station.hpp"
#include "tests/support/python_robot.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

Process::Ended tried(const std::vector<std::string>& options, const std::vector<std::string>& client,
                     const std::vector<std::string>& more = {}) {
  std::vector<std::string> argv{program("headframe-conformance")};
  argv.insert(argv.end(), options.begin(), options.end());
  argv.emplace_back("--");
  argv.insert(argv.end(), client.begin(), client.end());
  argv.insert(argv.end(),
              {"--server", "{server}", "--robot", "{robot}", "--enrol", "{enrol}", "--credential", "{credential}"});
  argv.insert(argv.end(), more.begin(), more.end());
  argv.emplace_back("{session}");
  auto process = Process::start(argv);
  if (!process) return {-1, process.error().message};
  const auto ended = process->wait(300s);
  return ended ? *ended : Process::Ended{-1, ended.error().message};
}

TEST(Conformance, TheRobotInPythonPasses) {
  const auto ended = tried({}, python_robot());
  EXPECT_EQ(ended.status, 0) << ended.output;
  const auto all = tried({"--scenario", "session"}, python_robot(), {"--clouds", "all"});
  EXPECT_EQ(all.status, 0) << all.output;
  const auto never = tried({"--scenario", "session"}, python_robot(), {"--clouds", "never"});
  EXPECT_EQ(never.status, 0) << never.output;
}

TEST(Conformance, TheLibrarysRobotPasses) {
  for (const std::string clouds : {"on_request", "all", "never"}) {
    const auto ended =
        tried(clouds == "on_request" ? std::vector<std::string>{} : std::vector<std::string>{"--scenario", "session"},
              {program("headframe-replay")},
              {"--spool", "{spool}", "--fast", "--family", "scan_context", "--linger", "0", "--clouds", clouds});
    EXPECT_EQ(ended.status, 0) << clouds << ": " << ended.output;
  }
}

struct Planted {
  std::string name, scenario, finding;
};

std::vector<Planted> planted() {
  auto argv = python_robot("faulty_robot.py");
  argv.emplace_back("list");
  std::istringstream lines(Process::start(argv).value().wait(60s).value().output);
  std::vector<Planted> all;
  for (Planted one; lines >> one.name >> one.scenario >> one.finding;) all.push_back(one);
  return all;
}

TEST(Conformance, EachPlantedFaultIsFound) {
  const auto faults = planted();
  ASSERT_GE(faults.size(), 20U);
  std::vector<Process::Ended> ends(faults.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < faults.size(); i = next++) {
      auto client = python_robot("faulty_robot.py");
      client.push_back(faults[i].name);
      // Twice at most: a starved robot may say nothing in the third of a second in which it should not have.
      for (int times = 0; times < 2 && ends[i].status != 1; ++times)
        ends[i] = tried({"--scenario", faults[i].scenario, "--patience", "20"}, client, {"--patience", "20"});
    }
  };
  {
    std::vector<std::jthread> threads;  // they mostly wait
    threads.reserve(4);
    for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  }
  for (std::size_t i = 0; i < faults.size(); ++i) {
    EXPECT_EQ(ends[i].status, 1) << faults[i].name << ": " << ends[i].output;
    EXPECT_NE(ends[i].output.find("WRONG " + faults[i].finding + " ("), std::string::npos)
        << faults[i].name << " is no " << faults[i].finding << ": " << ends[i].output;
  }
}

TEST(Conformance, AClientThatIsNoneIsSaid) {
  const auto ended = tried({"--scenario", "session", "--patience", "1"}, {"/bin/false"});
  EXPECT_EQ(ended.status, 1);
  EXPECT_NE(ended.output.find("did not connect"), std::string::npos) << ended.output;
  const auto unknown = tried({"--scenario", "sessions"}, {"/bin/false"});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.output.find("there are: session another-server"), std::string::npos) << unknown.output;
}

}  // namespace
}  // namespace headframe::test
