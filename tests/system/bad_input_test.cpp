// Each door with something wrong in it: one clear line, a non-zero exit, nothing lost, others not disturbed.

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <csignal>
#include <fstream>

#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;

Process::Ended run(const std::vector<std::string>& argv) {
  auto process = Process::start(argv);
  if (!process) return {-1, process.error().message};
  const auto ended = process->wait(60s);
  return ended ? *ended : Process::Ended{-1, ended.error().message};
}

/// Fails, and the last line says all of these words.
void expect_refused(const Process::Ended& ended, const std::vector<std::string>& words) {
  EXPECT_GT(ended.status, 0) << ended.output;
  EXPECT_LT(ended.status, 128) << "killed by a signal: " << ended.output;
  for (const auto& word : words)
    EXPECT_NE(ended.output.find(word), std::string::npos) << "no '" << word << "' in: " << ended.output;
}

struct BadInput : testing::Test {
  ScratchFolder scratch;
  std::filesystem::path at(const std::string& name) const { return scratch.path() / name; }

  Process::Ended serve(const std::vector<std::string>& options) const {
    std::vector<std::string> argv{program("headframe-server"), "--insecure", "--http", "127.0.0.1:0"};
    if (std::find(options.begin(), options.end(), "--listen") == options.end())
      argv.insert(argv.end(), {"--listen", "127.0.0.1:0"});
    argv.insert(argv.end(), options.begin(), options.end());
    return run(argv);
  }
};

TEST_F(BadInput, SessionFolders) {
  auto station = BaseStation::start(at("data"));
  ASSERT_TRUE(station) << station.error().message;
  const auto replay = [&](const std::filesystem::path& folder) {
    auto process = station->replay("r", folder);
    return process->wait(60s).value();
  };
  expect_refused(replay(at("missing")), {"missing"});
  const Drive drive = drive_a_to_c(6);
  const auto spoilt = [&](const std::string& name, const std::function<void(const std::filesystem::path&)>& spoil) {
    write_session(at(name), drive);
    spoil(at(name));
    return replay(at(name));
  };
  expect_refused(spoilt("no-poses", [](const auto& f) { std::filesystem::remove(f / "poses.txt"); }), {"poses.txt"});
  expect_refused(spoilt("more-poses", [](const auto& f) { std::filesystem::remove(f / "scans" / "000003.bin"); }),
                 {"poses"});
  expect_refused(
      spoilt("zero-quaternion", [](const auto& f) { std::ofstream(f / "poses.txt") << "0 0 0 0 0 0 0 0\n"; }),
      {"poses.txt", "1"});
  expect_refused(
      spoilt("truncated", [](const auto& f) { std::filesystem::resize_file(f / "scans" / "000002.bin", 1001); }),
      {"000002.bin"});
  const auto empty =
      spoilt("empty-scan", [](const auto& f) { std::filesystem::resize_file(f / "scans" / "000002.bin", 0); });
  EXPECT_EQ(empty.status, 0) << "an empty scan is passed over: " << empty.output;
}

TEST_F(BadInput, Server) {
  std::ofstream(at("file")) << "x";
  expect_refused(serve({"--data", at("file").string()}), {"file"});
  std::ofstream(at("bad.toml")) << "[server]\nno_such_key = 1\n";
  expect_refused(serve({"--data", at("d").string(), "--config", at("bad.toml").string()}), {"no_such_key", "bad.toml"});
  expect_refused(serve({"--data", at("d").string(), "--config", at("none.toml").string()}), {"none.toml"});
  for (const std::string door : {"--listen", "--http"})
    expect_refused(run({program("headframe-server"), "--data", at("d").string(), "--insecure", door, "0.0.0.0:0"}),
                   {"--insecure", "0.0.0.0:0", "loopback"});
  auto station = BaseStation::start(at("data"));
  ASSERT_TRUE(station) << station.error().message;
  expect_refused(serve({"--data", at("other").string(), "--listen", station->robots()}), {station->robots()});
  expect_refused(serve({"--data", at("data").string()}), {"data"});  // another server holds it
  station->process().signal(SIGTERM);
  EXPECT_EQ(station->process().wait(30s)->status, 0);

  for (const auto& entry : std::filesystem::directory_iterator(at("data"))) {
    if (entry.path().extension() != ".sqlite" && entry.path().extension() != ".db") continue;
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(entry.path().c_str(), &db), SQLITE_OK);
    sqlite3_exec(db, "PRAGMA user_version = 999", nullptr, nullptr, nullptr);
    sqlite3_close(db);
  }
  expect_refused(serve({"--data", at("data").string()}), {"999"});
}

TEST_F(BadInput, NoServer) {
  write_session(at("a"), drive_a_to_c(6));
  expect_refused(run({program("headframe"), "--http", "127.0.0.1:1", "status"}), {"127.0.0.1:1"});
  expect_refused(run({program("headframe"), "--http", "nonsense", "status"}), {"nonsense"});
  expect_refused(
      run({program("headframe-replay"), "--server", "nonsense", "--robot", "a", "--insecure", at("a").string()}),
      {"nonsense"});
}

std::string answer_to(const std::string& address, const std::string& bytes) {
  boost::asio::io_context io;
  tcp::socket socket(io);
  boost::asio::connect(
      socket, tcp::resolver(io).resolve(address.substr(0, address.find(':')), address.substr(address.find(':') + 1)));
  boost::asio::write(socket, boost::asio::buffer(bytes));
  std::string answer;
  boost::system::error_code ended;
  boost::asio::read(socket, boost::asio::dynamic_buffer(answer, 1 << 20), ended);  // until the server closes
  return answer;
}

TEST_F(BadInput, StrangersGetATypedErrorAndOthersAreNotDisturbed) {
  auto station = BaseStation::start(at("data"), "127.0.0.1:0", true);
  ASSERT_TRUE(station) << station.error().message;
  write_session(at("a"), drive_a_to_c(1));
  auto robot = station->replay("a", at("a"));
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.0\r\n\r\n"), std::string("\xff\xff\xff\xff", 4), std::string("\0\0\0\0", 4),
        std::string("\0\0\0\5hello", 9), std::string("\0\0\0\2\x3a\x00", 6)})
    EXPECT_GT(answer_to(station->robots(), bytes).size(), 4U) << "an error frame comes before the connection ends";
  const auto ended = robot->wait(60s);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->status, 0) << ended->output;
  EXPECT_EQ(station->process().poll(), -1) << "the server runs on";
}

}  // namespace
}  // namespace headframe::test
