// The real programs over HTTPS: what a server beyond the loopback speaks, and how the command finds it.

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include "tests/support/base_station.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

struct Https : testing::Test {
  /// Its lines up to the one that says that it is ready, or that it ended.
  void start(std::vector<std::string> more, const std::string& config = "") {
    std::vector<std::string> argv{program("headframe-server"), "--data", data.string(), "--listen", listen};
    argv.insert(argv.end(), more.begin(), more.end());
    if (!config.empty()) {
      std::ofstream(scratch.path() / "hf.toml") << config;
      argv.insert(argv.end(), {"--config", (scratch.path() / "hf.toml").string()});
    }
    auto started = Process::start(argv);
    ASSERT_TRUE(started);
    server.emplace(std::move(*started));
    printed.clear();
    while (const auto line = server->read_line(30s)) {
      printed += *line + "\n";
      if (line->find("ready: ") != std::string::npos) break;
    }
  }
  std::string after(const std::string& words) const {
    const auto at = printed.find(words);
    if (at == std::string::npos) return "";
    return printed.substr(at + words.size(), printed.find_first_of(",\n", at) - at - words.size());
  }
  std::string port() const {
    const std::string http = after("http on ");
    return http.substr(http.rfind(':') + 1);
  }
  Process::Ended status(const std::string& http, std::vector<std::string> more = {}) {
    return headframe(http, {"status"}, std::move(more));
  }
  static Process::Ended headframe(const std::string& http, const std::vector<std::string>& words,
                                  std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    more.insert(more.begin(), {program("headframe"), "--http", http});
    auto process = Process::start(more);
    return process->wait(60s).value();
  }

  std::string listen = "127.0.0.1:0";
  ScratchFolder scratch;
  const std::filesystem::path data = scratch.path() / "data";
  const std::string token = (data / "operator.token").string();
  std::optional<Process> server;
  std::string printed;
};

TEST_F(Https, BeyondTheLoopbackItIsSpokenWithoutAWordInTheConfiguration) {
  start({"--http", "0.0.0.0:0"});
  EXPECT_EQ(after("operators: "), "https://0.0.0.0:" + port() + "/") << printed;
  // Another machine has the token, and knows the server by what it printed.
  const auto copy = scratch.path() / "elsewhere.token";
  std::filesystem::copy_file(token, copy);
  const std::string there = "https://127.0.0.1:" + port(), fingerprint = after("fingerprint: ");
  const auto known = status(there, {"--token-file", copy.string(), "--fingerprint", fingerprint});
  EXPECT_EQ(known.status, 0) << known.output;
  const auto unknown = status(there, {"--token-file", copy.string()});
  EXPECT_EQ(unknown.status, 1);
  EXPECT_NE(unknown.output.find("--fingerprint " + fingerprint), std::string::npos) << unknown.output;
  EXPECT_EQ(status(there, {"--token-file", token}).status, 0) << "its certificate lies beside its token";
  const auto clear = status("http://127.0.0.1:" + port(), {"--token-file", token});
  EXPECT_EQ(clear.status, 1);
  EXPECT_NE(clear.output.find("speaks HTTPS"), std::string::npos) << clear.output;
}

TEST_F(Https, ARobotIsInvitedToAnAddressThatItCanConnectTo) {
  listen = "0.0.0.0:0";
  const auto told = [&](const std::vector<std::string>& words) {
    const auto ended = headframe("127.0.0.1:" + port(), words, {"--token-file", token});
    EXPECT_EQ(ended.status, 0) << ended.output;
    return ended.output;
  };
  start({"--http", "127.0.0.1:0"});
  const std::string at = after("robots on 0.0.0.0:");
  ASSERT_FALSE(at.empty()) << printed;
  const std::string asked = told({"robot", "add", "r1"});
  EXPECT_NE(asked.find("--server ADDRESS_OF_THE_SERVER:" + at + " --robot r1"), std::string::npos) << asked;
  server->signal(SIGTERM);
  ASSERT_TRUE(server->wait(30s));
  start({"--http", "127.0.0.1:0"}, "[server]\npublic = 'mine.example:7447'\n");
  const std::string given = told({"robot", "add", "r2"});
  EXPECT_NE(given.find("--server mine.example:7447 --robot r2"), std::string::npos) << given;
  EXPECT_NE(told({"servers"}).find("mine.example:7447"), std::string::npos);
}

TEST_F(Https, PlainHttpIsForTheLoopbackAndForWhoAsksForIt) {
  start({"--http", "127.0.0.1:0"});
  EXPECT_EQ(after("operators: "), "http://127.0.0.1:" + port() + "/");
  EXPECT_EQ(status("127.0.0.1:" + port(), {"--token-file", token}).status, 0);
  const auto secure = status("https://127.0.0.1:" + port(), {"--token-file", token});
  EXPECT_EQ(secure.status, 1);
  EXPECT_NE(secure.output.find("does not speak HTTPS"), std::string::npos) << secure.output;
  server.reset();
  start({"--http", "0.0.0.0:0"}, "[operator]\ntls = 'never'\n");
  EXPECT_EQ(after("operators: "), "http://0.0.0.0:" + port() + "/");
  EXPECT_NE(printed.find("is not encrypted"), std::string::npos) << printed;
  EXPECT_EQ(status("127.0.0.1:" + port(), {"--token-file", token}).status, 0);
}

TEST_F(Https, ACertificateThatIsGivenIsShownAndOneThatIsNotThereIsNamed) {
  start({"--http", "127.0.0.1:0"});
  const std::string pem = (scratch.path() / "given.pem").string();
  std::filesystem::rename(data / "identity.pem", pem);
  const std::string first = after("fingerprint: ");
  server.reset();
  const std::string config = "[operator]\ncertificate = '" + pem + "'\n";
  start({"--http", "127.0.0.1:0"}, config);
  EXPECT_EQ(after("operators: "), "https://127.0.0.1:" + port() + "/") << printed;
  EXPECT_NE(after("fingerprint: "), first) << "robots know the server by its own";
  EXPECT_EQ(status("https://127.0.0.1:" + port(), {"--token-file", token, "--fingerprint", first}).status, 0);
  server.reset();
  std::filesystem::remove(pem);
  start({"--http", "127.0.0.1:0"}, config);
  EXPECT_NE(printed.find("[operator]: " + pem), std::string::npos) << printed;
  EXPECT_EQ(server->wait(10s)->status, 1);
  start({"--http", "127.0.0.1:0", "--insecure"}, "[operator]\ntls = 'always'\n");
  EXPECT_NE(printed.find("--insecure serves operators without TLS"), std::string::npos) << printed;
  EXPECT_EQ(server->wait(10s)->status, 1);
}

}  // namespace
}  // namespace headframe::test
