// Peers that misbehave on their own sockets, and one robot that must not notice.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <thread>

#include "server/map_merge_server.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

class RobotsApart : public testing::Test {
 protected:
  void SetUp() override {
    ServerConfig config;
    config.limits.hello_s = config.limits.silence_s = 0.5;
    config.limits.ping_s = 0.2;
    auto started = MapMergeServer::start({folder_.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, config, true});
    ASSERT_TRUE(started) << started.error().message;
    server_ = std::move(*started);
  }

  tcp::socket peer(const std::string& says) {
    tcp::socket socket(io_);
    socket.connect({boost::asio::ip::make_address("127.0.0.1"), server_->robots().port});
    error_code ignored;
    boost::asio::write(socket, boost::asio::buffer(says), ignored);
    return socket;
  }

  /// What the server says until it closes; it waits for that at most ten seconds.
  static std::string until_closed(tcp::socket& socket) {
    const timeval patience{10, 0};
    ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::string all;
    char bytes[4096];
    ssize_t n = 0;
    while ((n = ::recv(socket.native_handle(), bytes, sizeof bytes, 0)) > 0)
      all.append(bytes, static_cast<std::size_t>(n));
    EXPECT_TRUE(n == 0 || errno == ECONNRESET) << "the connection is still open";
    return all;
  }

  /// A whole drive of a well-behaved robot.
  void drive_well() {
    const auto robot =
        RobotClient::open(bench::drive_config("good", folder_.path() / "spool", "127.0.0.1", server_->robots().port));
    ASSERT_TRUE(robot) << robot.error().message;
    for (std::uint64_t i = 1; i <= 20; ++i) ASSERT_TRUE(bench::add_drive_keyframe(**robot, "good", i).value());
    const auto done = (*robot)->finish(std::chrono::seconds(20));
    EXPECT_TRUE(done) << done.error().message;
    EXPECT_EQ((*robot)->progress().link_error, "") << "its link never broke";
  }

  TempDir folder_;
  boost::asio::io_context io_;
  std::unique_ptr<MapMergeServer> server_;
};

TEST_F(RobotsApart, SilentAndHalfOpenPeersAreClosedAndNobodyWaitsForThem) {
  auto silent = peer(""), torn = peer(hello_frame().substr(0, 20)), asleep = peer(hello_frame(robot_hello("asleep")));
  drive_well();
  EXPECT_NE(until_closed(silent).find("no hello"), std::string::npos);
  EXPECT_NE(until_closed(torn).find("no hello"), std::string::npos);
  EXPECT_NE(until_closed(asleep).find("not even a pong"), std::string::npos);
}

TEST_F(RobotsApart, AFloodFromAPeerThatNeverReadsHoldsUpNobody) {
  v1::RobotMessage ping;
  ping.mutable_ping()->set_nonce(1);
  std::string pings;
  for (int i = 0; i < 5000; ++i) pings += frame(ping);
  auto flooding = peer(hello_frame(robot_hello("flood")));
  std::atomic<bool> stop{false};
  std::thread flood([&] {
    error_code error;
    while (!stop && !error) boost::asio::write(flooding, boost::asio::buffer(pings), error);
  });
  drive_well();
  stop = true;
  flooding.shutdown(tcp::socket::shutdown_both);
  flood.join();
}

TEST_F(RobotsApart, GarbageEndsItsOwnConnectionOnly) {
  auto garbage = peer(std::string(1000, '\xff')), huge = peer(std::string("\x7f\xff\xff\xff", 4));
  drive_well();
  EXPECT_FALSE(until_closed(garbage).empty());
  EXPECT_FALSE(until_closed(huge).empty());
}

}  // namespace
}  // namespace headframe
