// Who may come in, met with the real programs: each that may not gets one clear line, and the server serves on.
#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <csignal>
#include <fstream>
#include <sstream>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;

class Security : public testing::Test {
 protected:
  void SetUp() override {
    write_session(at("a"), drive_a_to_c(6));
    auto started = BaseStation::start(at("data"));
    ASSERT_TRUE(started) << started.error().message;
    station.emplace(std::move(*started));
  }

  std::filesystem::path at(const std::string& name) const { return scratch.path() / name; }
  std::filesystem::path credential() const { return at("data-a.credential"); }

  /// headframe-replay as robot a with these options and no others.
  Process::Ended replay(const std::string& server, const std::vector<std::string>& options) const {
    std::vector<std::string> argv{program("headframe-replay"), "--server", server, "--robot", "a", "--fast"};
    argv.insert(argv.end(), options.begin(), options.end());
    argv.push_back(at("a").string());
    auto process = Process::start(argv);
    const auto ended = process ? process->wait(60s) : tl::unexpected(process.error());
    return ended ? *ended : Process::Ended{-1, ended.error().message};
  }
  Process::Ended replay(const std::vector<std::string>& options) const { return replay(station->robots(), options); }
  std::vector<std::string> with_credential() const { return {"--credential", credential().string()}; }

  void enrol() const {
    const auto ended = replay(*station->admission("a"));
    ASSERT_EQ(ended.status, 0) << ended.output;
  }

  static void expect_refused(const Process::Ended& ended, const std::string& says) {
    EXPECT_EQ(ended.status, 1) << ended.output;
    EXPECT_NE(ended.output.find(says), std::string::npos) << "no '" << says << "' in: " << ended.output;
  }

  /// Stops the server and gives what it has said.
  std::string log() {
    station->process().signal(SIGTERM);
    const auto ended = station->process().wait(30s);
    EXPECT_TRUE(ended && ended->status == 0);
    return ended ? ended->output : "";
  }

  void change_credential(const std::string& what, const std::string& to) const {
    std::ifstream in(credential());
    std::stringstream content;
    const std::string changed = what + " " + to;
    for (std::string line; std::getline(in, line);) content << (line.rfind(what, 0) == 0 ? changed : line) << "\n";
    std::ofstream(credential()) << content.str();
  }
  std::string credential_line(const std::string& what) const {
    std::ifstream in(credential());
    for (std::string line; std::getline(in, line);)
      if (line.rfind(what + " ", 0) == 0) return line.substr(what.size() + 1);
    return "";
  }

  ScratchFolder scratch;
  std::optional<BaseStation> station;
};

TEST_F(Security, ACodeIsGoodOnceAndSecretsAreInNoLog) {
  const std::string enrolment = *station->enrolment("a");
  EXPECT_NE(enrolment.find(station->fingerprint()), std::string::npos);
  const auto first = replay({"--enrol", enrolment, "--credential", credential().string()});
  ASSERT_EQ(first.status, 0) << first.output;
  const auto again = replay({"--enrol", enrolment, "--credential", credential().string()});
  EXPECT_EQ(again.status, 0) << "its own start file may go on to name it: " << again.output;
  const auto thief = replay({"--enrol", enrolment, "--credential", at("stolen").string()});
  expect_refused(thief, "was used");

  const std::string code = enrolment.substr(enrolment.rfind('-') + 1), token = credential_line("token");
  ASSERT_EQ(code.size(), 32U);
  ASSERT_EQ(token.size(), 64U);
  const std::string said = log() + first.output + again.output + thief.output;
  for (const std::string& secret : {code, token, *station->token()}) EXPECT_EQ(said.find(secret), std::string::npos);
}

TEST_F(Security, AnotherServerIsNotTalkedTo) {
  enrol();
  auto options = with_credential();
  options.insert(options.end(), {"--patience", "1", "--fingerprint", std::string(64, 'a')});
  expect_refused(replay(options), "not the server that is pinned: its fingerprint is " + station->fingerprint());
  EXPECT_NE(log().find("pins another fingerprint"), std::string::npos);
}

TEST_F(Security, ALostIdentityIsNotSilentlyReplaced) {
  enrol();
  (void)log();
  ASSERT_TRUE(std::filesystem::remove(at("data") / "identity.pem"));
  const auto again = BaseStation::start(at("data"));
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("identity.pem is missing"), std::string::npos) << again.error().message;
  EXPECT_FALSE(std::filesystem::exists(at("data") / "identity.pem"));
  auto anew = Process::start({program("headframe-server"), "--data", at("data").string(), "--listen", "127.0.0.1:0",
                              "--http", "127.0.0.1:0", "--new-identity"});
  ASSERT_TRUE(anew);
  std::string said;  // its log may come first
  while (said.find("fingerprint") == std::string::npos) {
    const auto line = anew->read_line(10s);
    if (!line) break;
    said += *line + '\n';
  }
  EXPECT_NE(said.find("fingerprint"), std::string::npos) << said;
}

TEST_F(Security, AWrongTokenIsNoCredential) {
  enrol();
  change_credential("token", std::string(64, '0'));
  expect_refused(replay(with_credential()), "this is not its credential");
  EXPECT_NE(log().find("robot a: this is not its credential"), std::string::npos);
}

TEST_F(Security, ARobotsTokenOpensNoOtherRobotsSessions) {
  enrol();
  const auto b = station->replay("b", at("a"))->wait(60s);
  ASSERT_TRUE(b && b->status == 0);
  const std::string of_a = credential_line("token");
  std::filesystem::copy(at("data-b.credential"), credential(), std::filesystem::copy_options::overwrite_existing);
  change_credential("robot", "a");
  EXPECT_NE(credential_line("token"), of_a);
  expect_refused(replay(with_credential()), "robot a: this is not its credential");
}

TEST_F(Security, ARevokedRobotIsCutOffAtOnceAndStaysOut) {
  const auto admission = station->admission("a");
  std::vector<std::string> argv{
      program("headframe-replay"), "--server", station->robots(), "--robot", "a", "--fast", "--linger", "600"};
  argv.insert(argv.end(), admission->begin(), admission->end());
  argv.push_back(at("a").string());
  auto live = Process::start(argv);
  ASSERT_TRUE(live);
  const auto keyframes = [&] {
    const auto sessions = nlohmann::json::parse(station->command({"sessions", "--json"})->output).at("sessions");
    return sessions.empty() ? 0 : sessions[0].at("keyframes").get<int>();
  };
  while (keyframes() == 0 && live->poll() < 0) continue;
  EXPECT_EQ(station->command({"robot", "revoke", "a"})->status, 0);
  const int when_revoked = keyframes();
  expect_refused(*live->wait(60s), "robot a: it was revoked");
  EXPECT_LE(keyframes(), when_revoked + 64) << "what was in the store's queue, no more";
  expect_refused(replay(with_credential()), "robot a: it was revoked");
  EXPECT_NE(station->command({"robot", "list"})->output.find("a: revoked"), std::string::npos);
  const auto anew = *station->enrolment("a");
  EXPECT_EQ(replay({"--enrol", anew, "--credential", credential().string()}).status, 0) << "it may enrol anew";
}

TEST_F(Security, WhoSpeaksInTheClearToTheTlsPortIsToldSo) {
  expect_refused(replay({"--insecure"}), "this port takes TLS only");
  EXPECT_NE(log().find("this port takes TLS only"), std::string::npos);
}

TEST_F(Security, WhoSpeaksTlsToAPlainPortIsToldSo) {
  enrol();
  auto plain = BaseStation::start(at("plain"), "127.0.0.1:0", true);
  ASSERT_TRUE(plain) << plain.error().message;
  auto options = with_credential();
  options.insert(options.end(), {"--patience", "1"});
  expect_refused(replay(plain->robots(), options), "does not speak TLS");
  plain->process().signal(SIGTERM);
  EXPECT_NE(plain->process().wait(30s)->output.find("this server runs with --insecure"), std::string::npos);
}

TEST_F(Security, AnOlderTlsIsRefusedWithALine) {
  boost::asio::io_context io;
  boost::asio::ssl::context old(boost::asio::ssl::context::tlsv12_client);
  boost::asio::ssl::stream<tcp::socket> stream(io, old);
  const std::string& where = station->robots();
  boost::asio::connect(stream.lowest_layer(),
                       tcp::resolver(io).resolve(where.substr(0, where.find(':')), where.substr(where.find(':') + 1)));
  boost::system::error_code refused;
  stream.handshake(boost::asio::ssl::stream_base::client, refused);
  EXPECT_TRUE(refused);
  enrol();
  EXPECT_NE(log().find("ours is TLS 1.3"), std::string::npos);
}

TEST_F(Security, ACopyOfASpoolIsRefused) {
  enrol();
  auto options = with_credential();
  options.insert(options.end(), {"--spool", at("spool").string()});
  ASSERT_EQ(replay(options).status, 0);
  std::filesystem::copy(at("spool"), at("clone"), std::filesystem::copy_options::recursive);
  EXPECT_EQ(replay(options).status, 0) << "the original goes on";
  options.back() = at("clone").string();
  expect_refused(replay(options), "one of the two disks is a clone");
}

TEST_F(Security, WithoutCredentialItSaysHowToGetOne) {
  expect_refused(replay({"--credential", at("none").string()}), "headframe robot add a");
  expect_refused(replay({"--credential", at("none").string(), "--enrol", "hf1-half"}), "paste the whole");
  const auto unknown = station->command({"robot", "revoke", "nobody"});
  expect_refused(*unknown, "there is no robot \"nobody\"");
}

}  // namespace
}  // namespace headframe::test
