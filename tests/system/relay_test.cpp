// The relay alone, between real sockets.
#include "server/net/relay.hpp"

#include <mutex>
#include <thread>

#include "server/security/relay_header.hpp"
#include "tests/support/plain_peer.hpp"

namespace headframe {
namespace {

using boost::asio::ip::tcp;
const Endpoint any_port{"127.0.0.1", 0};

struct RelayTest : testing::Test {
  void relay(const RelayLimits& limits = {}, Relay::Target to = {}) {
    if (!to) to = [this] { return where(); };
    relays.push_back(std::make_unique<Relay>(key, std::move(to), limits));
    const auto listening = relays.back()->listen(any_port);
    ASSERT_TRUE(listening) << listening.error().message;
    at = *listening;
  }

  /// A server's end of the connection of a client that has just come, after the header and the client's greeting.
  std::unique_ptr<PlainPeer> greeted(PlainPeer& client) {
    client.send("hello");
    auto peer = std::make_unique<PlainPeer>(server);
    header = peer->read(relay_preamble_bytes);
    if (const auto left = relay_bytes_left(header)) header += peer->read(*left);
    EXPECT_TRUE(relayed_client(header, key)) << "the header comes first";
    EXPECT_EQ(peer->read(5), "hello");
    return peer;
  }

  void go_to(Result<Endpoint> to) {
    const std::lock_guard lock(mutex);
    target = std::move(to);
  }
  Result<Endpoint> where() {
    const std::lock_guard lock(mutex);
    return target;
  }

  /// Looks until it holds.
  static bool until(const std::function<bool()>& holds) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!holds() && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
    return holds();
  }

  const std::string key = relay_key("token");
  boost::asio::io_context io;
  tcp::acceptor server{io, {boost::asio::ip::address_v4::loopback(), 0}};
  std::mutex mutex;
  Result<Endpoint> target = Endpoint{"127.0.0.1", server.local_endpoint().port()};
  std::vector<std::unique_ptr<Relay>> relays;
  Endpoint at;
  std::string header;
};

TEST_F(RelayTest, BytesGoBothWaysBehindAHeaderWithTheClientsAddress) {
  relay();
  PlainPeer client(at, "127.0.0.2");
  const auto peer = greeted(client);
  EXPECT_EQ(relayed_client(header, key).value().to_string(), "127.0.0.2");
  peer->send("welcome");
  EXPECT_EQ(client.read(7), "welcome");
  EXPECT_EQ(relays[0]->connections(), 1);
}

TEST_F(RelayTest, ANameIsLookedUp) {
  target->host = "localhost";
  relay();
  PlainPeer client(at);
  const auto peer = greeted(client);
  client.send("again");
  EXPECT_EQ(peer->read(5), "again");
}

/// Who does not read is waited for, and nothing is lost meanwhile.
TEST_F(RelayTest, MegabytesGoBothWaysAtOnce) {
  relay();
  PlainPeer client(at);
  const auto peer = greeted(client);
  std::string much(8 << 20, '\0');
  for (std::size_t i = 0; i < much.size(); ++i) much[i] = static_cast<char>(i % 251);
  std::thread up([&] { EXPECT_TRUE(client.send(much)); }), down([&] { EXPECT_TRUE(peer->send(much)); });
  EXPECT_EQ(peer->read(much.size()), much);
  EXPECT_EQ(client.read(much.size()), much);
  up.join();
  down.join();
}

TEST_F(RelayTest, TheEndOfOneSideIsPassedOnAndTheOtherGoesOn) {
  relay();
  PlainPeer client(at);
  const auto peer = greeted(client);
  client.send("question");
  client.end_sending();
  EXPECT_EQ(peer->rest(), "question");
  peer->send("answer");
  peer->end_sending();
  EXPECT_EQ(client.rest(), "answer");
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 0; }));
}

TEST_F(RelayTest, ASideThatNeverEndsIsEndedAfterTheOther) {
  RelayLimits limits;
  limits.half_closed_for = std::chrono::seconds(0);
  relay(limits);
  PlainPeer client(at);
  const auto peer = greeted(client);
  peer->end_sending();
  EXPECT_TRUE(client.is_turned_away());
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 0; })) << "though the client has not ended";
}

TEST_F(RelayTest, OneThatIsResetTakesItsOtherHalfAlongAndNoOther) {
  relay();
  PlainPeer other(at);
  const auto others_peer = greeted(other);
  {
    PlainPeer client(at);
    const auto peer = greeted(client);
    client.socket().set_option(boost::asio::socket_base::linger(true, 0));
    client.socket().close();
    EXPECT_TRUE(peer->is_turned_away());
  }
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 1; }));
  other.send("hello");
  EXPECT_EQ(others_peer->read(5), "hello");
}

TEST_F(RelayTest, WithNowhereToGoItTurnsAway) {
  relay();
  go_to(failure(ErrorCode::unavailable, "nobody is active"));
  EXPECT_TRUE(PlainPeer(at).is_turned_away());
  go_to(failure(ErrorCode::refused, "it is not reached from here"));
  EXPECT_TRUE(PlainPeer(at).is_turned_away());
  server.close();
  go_to(Endpoint{"127.0.0.1", 1});
  PlainPeer client(at);
  client.send("hello");
  EXPECT_TRUE(client.is_turned_away()) << "nobody listens there";
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 0; }));
}

/// A server that is there and takes no connections any more: its queue is full.
TEST_F(RelayTest, AServerThatDoesNotAnswerIsWaitedForSoLong) {
  tcp::acceptor full(io);
  full.open(tcp::v4());
  full.bind({boost::asio::ip::address_v4::loopback(), 0});
  full.listen(0);
  go_to(Endpoint{"127.0.0.1", full.local_endpoint().port()});
  std::vector<std::unique_ptr<tcp::socket>> others;  // until its queue takes no more
  for (int i = 0; i < 4; ++i) {
    others.push_back(std::make_unique<tcp::socket>(io, tcp::v4()));
    others.back()->non_blocking(true);
    (void)::connect(others.back()->native_handle(), full.local_endpoint().data(), full.local_endpoint().size());
  }
  RelayLimits limits;
  limits.connect_within = std::chrono::seconds(0);
  relay(limits);
  PlainPeer client(at);
  client.send("hello");
  EXPECT_TRUE(client.is_turned_away());
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 0; }));
}

TEST_F(RelayTest, OneMoreThanTheBoundIsTurnedAwayAndAFloodChangesNothing) {
  RelayLimits limits;
  limits.connections = 2;
  relay(limits);
  PlainPeer a(at);
  auto a_peer = greeted(a);
  PlainPeer b(at);
  const auto b_peer = greeted(b);
  for (int i = 0; i < 300; ++i) EXPECT_TRUE(PlainPeer(at).is_turned_away());
  EXPECT_EQ(relays[0]->connections(), 2);
  b.send("hello");
  EXPECT_EQ(b_peer->read(5), "hello");
  a_peer.reset();
  EXPECT_TRUE(a.is_turned_away());
  a.end_sending();
  ASSERT_TRUE(until([&] { return relays[0]->connections() == 1; }));
  PlainPeer c(at);
  const auto c_peer = greeted(c);
  c.send("room");
  EXPECT_EQ(c_peer->read(4), "room");
}

TEST_F(RelayTest, WhoSaysNothingIsClosedAfterAWhileAndTheOldestForOneMore) {
  RelayLimits limits;
  limits.silent = 2;
  relay(limits);
  PlainPeer a(at), b(at), c(at);
  EXPECT_TRUE(a.is_turned_away());
  EXPECT_EQ(relays[0]->connections(), 2);
  const auto b_peer = greeted(b);
  PlainPeer d(at);
  const auto c_peer = greeted(c), d_peer = greeted(d);
  EXPECT_EQ(relays[0]->connections(), 3) << "who has spoken makes room for nobody";
  limits.speak_within = std::chrono::seconds(0);
  relay(limits);
  EXPECT_TRUE(PlainPeer(at).is_turned_away());
}

TEST_F(RelayTest, NothingThatWasPassedOnIsPassedOnAgain) {
  const Endpoint served = *target;
  relay();
  go_to(at);
  PlainPeer lost(at);
  lost.send("hello");
  EXPECT_TRUE(lost.is_turned_away()) << "it came back to its own port";
  lost.end_sending();
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 0; }));
  go_to(served);
  const Endpoint second = at;
  PlainPeer direct(second);
  const auto peer = greeted(direct);
  relay({}, [second] { return Result<Endpoint>(second); });
  PlainPeer twice(at);
  twice.send("hello");
  EXPECT_TRUE(twice.is_turned_away()) << "from one to another";
  EXPECT_TRUE(until([&] { return relays[0]->connections() == 1; })) << "but who came there first is";
}

TEST_F(RelayTest, ItEndsAllAtOnceAndItsPortIsFreeAgain) {
  relay();
  PlainPeer client(at);
  const auto peer = greeted(client);
  PlainPeer silent(at);
  ASSERT_TRUE(until([&] { return relays[0]->connections() == 2; }));
  relays[0]->stop();
  EXPECT_EQ(relays[0]->connections(), 0);
  EXPECT_TRUE(client.is_turned_away());
  EXPECT_TRUE(peer->is_turned_away());
  EXPECT_TRUE(silent.is_turned_away());
  relays[0]->stop();
  Relay again(key, [this] { return where(); });
  EXPECT_TRUE(again.listen(at)) << "while the one before is still there";
}

TEST_F(RelayTest, APortThatIsTakenIsSaid) {
  Relay other(key, [this] { return where(); });
  const auto taken = other.listen(*target);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, ErrorCode::unavailable);
}

}  // namespace
}  // namespace headframe
