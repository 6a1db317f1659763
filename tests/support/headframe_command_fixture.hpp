#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/operator_server.hpp"

namespace headframe {

namespace fs = std::filesystem;
using Json = nlohmann::json;

inline std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs the command as an operator does: a process, against a server on the loopback.
class HeadframeCommand : public testing::Test {
 protected:
  HeadframeCommand() {
    std::string name = testing::TempDir() + "headframe-XXXXXX";
    folder = mkdtemp(name.data());
  }
  ~HeadframeCommand() override { fs::remove_all(folder); }

  Outcome run(const std::string& arguments) const { return run_at(server.where(), arguments); }
  Outcome run_at(const std::string& where, const std::string& arguments) const {
    const std::string line = std::string(HEADFRAME_COMMAND) + " --http " + where + " " + arguments + " >" +
                             path("out") + " 2>" + path("err") + " </dev/null";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(path("out")), contents(path("err"))};
  }
  std::string path(const std::string& file) const { return (folder / file).string(); }
  std::set<std::string> files() const {
    std::set<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder)) out.insert(entry.path().filename().string());
    out.erase("out");
    out.erase("err");
    return out;
  }
  static void expect_fault(const Outcome& outcome, int code, const std::string& says) {
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.rfind("headframe: ", 0), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(says), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << "one line: " << outcome.err;
  }

  OperatorServer server;
  fs::path folder;
};

}  // namespace headframe
