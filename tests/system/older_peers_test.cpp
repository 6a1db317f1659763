// Robots and servers of before the capability lists go on with those of today: recorded bytes of theirs.

#include <gtest/gtest.h>

#include <fstream>

#include "common/wire/capabilities.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/drawn_session.hpp"
#include "tests/support/raw_robot.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* recorded = HEADFRAME_SOURCE_DIR "/proto/headframe/v1/vectors/before_capabilities/";

std::string bytes_of(const std::string& name) {
  std::ifstream in(recorded + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(OlderPeers, AnOlderRobotsBytesAreTakenByTheRealServer) {
  const ScratchFolder scratch;
  const auto station = BaseStation::start(scratch.path() / "data", "127.0.0.1:0", true);
  ASSERT_TRUE(station) << station.error().message;
  RawRobot robot(*parse_peer(station->robots()));
  const std::string bytes = bytes_of("robot_bytes.bin");
  ASSERT_GT(bytes.size(), 1000U);
  robot.send(bytes);
  const auto first = robot.read();
  ASSERT_TRUE(first && first->has_welcome());
  const auto& listed = first->welcome().capabilities();
  EXPECT_EQ(std::vector<std::string>(listed.begin(), listed.end()), server_capabilities());
  std::uint64_t keyframes = 0;
  std::set<std::uint64_t> clouds;
  while (const auto message = robot.read()) {
    EXPECT_FALSE(message->has_error()) << message->error().message();
    if (message->has_keyframe_ack()) keyframes = message->keyframe_ack().durable_keyframes();
    for (const auto sequence : message->cloud_ack().sequences()) clouds.insert(sequence);
    if (keyframes == 3 && clouds.size() == 3) break;
  }
  EXPECT_EQ(keyframes, 3U);
  EXPECT_EQ(clouds, (std::set<std::uint64_t>{1, 2, 3}));
}

TEST(OlderPeers, AnOlderSpoolGoesOnWithTheRobotOfToday) {
  const ScratchFolder scratch;
  auto station = BaseStation::start(scratch.path() / "data", "127.0.0.1:0", true);
  ASSERT_TRUE(station) << station.error().message;
  std::filesystem::create_directories(scratch.path() / "spool" / "clouds");
  std::ofstream(scratch.path() / "spool" / "session.log", std::ios::binary) << bytes_of("spool_session.log");
  write_session(scratch.path() / "on", drive_a_to_c(4));
  auto replay = station->replay("elder", scratch.path() / "on",
                                {"--family", "scan_context", "--spool", (scratch.path() / "spool").string()});
  ASSERT_TRUE(replay);
  const auto ended = replay->wait(60s);
  ASSERT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
  EXPECT_NE(ended->output.find("after keyframe 3"), std::string::npos) << ended->output;
  const auto rows = nlohmann::json::parse(station->command({"sessions", "--json"})->output).at("sessions");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_GT(rows[0].at("keyframes"), 3) << "what the older robot spooled, and what was driven since";
}

class OlderServer : public UplinkProtocolTest {};

TEST_F(OlderServer, ARobotOfTodayTakesItsBytes) {
  table_.keyframes = 3;
  table_.clouds = {{1, "one"}, {2, "two"}, {3, "three"}};
  start();
  EXPECT_EQ(sent(), Words{"hello"});
  std::string bytes = bytes_of("server_bytes.bin");
  const std::size_t welcome = 4 + static_cast<unsigned char>(bytes.at(3));
  take(link_->receive(bytes.substr(0, welcome), now_));
  ASSERT_TRUE(link_->welcomed());
  EXPECT_TRUE(std::get<Welcomed>(events_.front()).capabilities.empty());
  EXPECT_EQ(std::get<Welcomed>(events_.front()).spares, 8U);
  EXPECT_EQ(sent(), (Words{"k1", "k2", "k3", "c1:0", "c2:0", "c3:0"}));
  take(link_->receive(bytes.substr(welcome), now_));
  EXPECT_FALSE(link_->ended());
  std::uint64_t durable = 0;
  std::set<std::uint64_t> clouds;
  for (const auto& event : events_) {
    if (const auto* keyframes = std::get_if<KeyframesDurable>(&event)) durable = keyframes->up_to;
    if (const auto* cloud = std::get_if<CloudsDurable>(&event)) clouds.insert(cloud->first);
  }
  EXPECT_EQ(durable, 3U);
  EXPECT_EQ(clouds, (std::set<std::uint64_t>{1, 2, 3}));
}

TEST_F(OlderServer, CapabilitiesComeWithTheWelcomeAndWhatIsNoNameIsPassedOver) {
  start();
  (void)sent();
  v1::ServerMessage m;
  m.mutable_welcome()->set_protocol_version(protocol_version);
  for (const std::string& name : {std::string("spares"), std::string("NO NAME"), std::string(), std::string(33, 'x'),
                                  std::string(32, 'x'), std::string("of_a_later_server_2")})
    m.mutable_welcome()->add_capabilities(name);
  hear(m);
  EXPECT_EQ(std::get<Welcomed>(events_.front()).capabilities,
            (std::vector<std::string>{"spares", std::string(32, 'x'), "of_a_later_server_2"}));
  EXPECT_EQ(usable_capabilities(std::vector<std::string>(65, "a")).size(), 64U);
  EXPECT_EQ(usable_capabilities(server_capabilities()), server_capabilities());
  EXPECT_EQ(usable_capabilities(robot_capabilities(true)), robot_capabilities(true));
}

}  // namespace
}  // namespace headframe::test
