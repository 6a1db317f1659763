// What a door learns of a connection before it reads anything.
#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <chrono>

#include "server/security/relayed_peer.hpp"
#include "tests/support/plain_peer.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;

class FirstByte : public testing::Test {
 protected:
  void wait() {
    async_first_byte(door, [this](std::optional<unsigned char> first) {
      ++answers;
      seen = first;
    });
  }
  /// Until nobody waits any more, or for ten seconds.
  void run() { io.run_for(std::chrono::seconds(10)); }

  boost::asio::io_context io;
  tcp::acceptor acceptor{io, {boost::asio::ip::make_address("127.0.0.1"), 0}};
  PlainPeer peer{{"127.0.0.1", acceptor.local_endpoint().port()}};
  tcp::socket door{acceptor.accept()};
  int answers = 0;
  std::optional<unsigned char> seen;
};

TEST_F(FirstByte, IsSeenAndLeftToBeRead) {
  peer.send("ab");
  wait();
  run();
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(seen, 'a');
  std::array<char, 2> bytes{};
  boost::asio::read(door, boost::asio::buffer(bytes));
  EXPECT_EQ(std::string(bytes.data(), bytes.size()), "ab");
}

/// Both waits end with the first byte, and the other one reads it: the wait for a first byte has ended without one.
TEST_F(FirstByte, IsWaitedForAgainIfAWaitEndsWithoutOne) {
  int woken = 0;
  door.async_wait(tcp::socket::wait_read, [&](const boost::system::error_code&) {
    char byte = 0;
    door.read_some(boost::asio::buffer(&byte, 1));
    EXPECT_EQ(byte, 'a');
    EXPECT_EQ(++woken + answers, 1) << "this wait is the first to end";
    boost::asio::post(io, [&] { peer.send("b"); });
  });
  wait();
  peer.send("a");
  run();
  EXPECT_EQ(woken, 1);
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(seen, 'b');
}

TEST_F(FirstByte, DoesNotComeWhereTheConnectionEnds) {
  wait();
  peer.end_sending();
  run();
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(seen, std::nullopt);
}

TEST_F(FirstByte, DoesNotComeWhereTheWaitIsCancelled) {
  wait();
  boost::asio::post(io, [&] { door.close(); });
  run();
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(seen, std::nullopt);
}

}  // namespace
}  // namespace headframe
