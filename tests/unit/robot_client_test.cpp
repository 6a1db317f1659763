#include "client/robot_client.hpp"

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/convert.hpp"
#include "common/wire/frame_codec.hpp"
#include "common/wire/pose_message.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;

/// A base station that keeps what it gets in memory and does what the test's script says. Its thread serves one
/// connection after another until it is destroyed.
class ScriptedStation {
 public:
  int drop_after_chunks = -1;       // of the first connection
  std::uint64_t refused_cloud = 0;  // by its keyframe's sequence
  v1::ErrorReport refusal;          // sent instead of a welcome when it has a message
  std::vector<std::string> capabilities;

  void start() {
    thread_ = std::thread([this] { serve(); });
  }
  ~ScriptedStation() {
    stopping_ = true;
    boost::asio::io_context io;
    tcp::socket last(io);  // wakes the accept
    boost::system::error_code ignored;
    last.connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

  // Read after the robot is closed.
  std::vector<Keyframe> keyframes;
  std::map<std::uint64_t, KeyframeCloud> clouds;
  std::map<std::uint64_t, Pose> moved;        // keyframes, by updates of poses
  std::vector<std::uint64_t> keyframes_then;  // when each update came
  std::uint64_t pose_update = 0;
  int connections = 0, chunks = 0, triggers = 0;
  std::vector<std::string> sessions;
  bool complete = false;

 private:
  void serve() {
    while (!stopping_) {
      tcp::socket socket(io_);
      acceptor_.accept(socket);
      if (stopping_) return;
      ++connections;
      FrameReader frames;
      std::array<char, 4096> buffer{};
      boost::system::error_code code;
      for (bool open = true; open;) {
        const auto n = socket.read_some(boost::asio::buffer(buffer), code);
        if (code) break;
        frames.feed({buffer.data(), n});
        while (open) {
          const auto payload = frames.next();
          if (!payload || !*payload) break;
          v1::RobotMessage message;
          open = message.ParseFromString(**payload) && answer(socket, message);
        }
      }
      partial_.clear();
    }
  }

  bool answer(tcp::socket& socket, const v1::RobotMessage& m) {
    v1::ServerMessage reply;
    if (m.has_hello()) {
      sessions.push_back(from_proto(m.hello())->session.session);
      if (!refusal.message().empty()) {
        *reply.mutable_error() = refusal;
      } else {
        reply.mutable_welcome()->set_protocol_version(protocol_version);
        reply.mutable_welcome()->set_durable_keyframes(keyframes.size());
        reply.mutable_welcome()->set_durable_pose_update(pose_update);
        for (const auto& name : capabilities) reply.mutable_welcome()->add_capabilities(name);
        for (const auto& [sequence, cloud] : clouds) {
          auto& range = *reply.mutable_welcome()->add_durable_clouds();
          range.set_first(sequence);
          range.set_last(sequence);
        }
      }
    } else if (m.has_keyframe()) {
      keyframes.push_back(*from_proto(m.keyframe()));
      reply.mutable_keyframe_ack()->set_durable_keyframes(keyframes.size());
    } else if (m.has_pose_update()) {
      const auto part = from_proto(m.pose_update()).value();
      for (const KeyframePose& pose : part.poses) moved[pose.sequence] = pose.T_local_sensor;
      if (part.offset + part.poses.size() < part.total_poses) return true;
      keyframes_then.push_back(keyframes.size());
      reply.mutable_pose_update_ack()->set_durable_pose_update(pose_update = part.number);
    } else if (m.has_cloud_chunk()) {
      const auto& c = m.cloud_chunk();
      if (++chunks == drop_after_chunks) return false;
      auto& bytes = partial_[c.sequence()];
      EXPECT_EQ(c.offset(), bytes.size());
      bytes += c.data();
      if (bytes.size() < c.total_bytes()) return true;
      if (c.sequence() == refused_cloud) {
        reply.mutable_cloud_refusal()->set_sequence(refused_cloud);
        reply.mutable_cloud_refusal()->set_reason("it is damaged");
        return send(socket, reply);
      }
      clouds[c.sequence()] = decode_cloud(bytes).value();
      reply.mutable_cloud_ack()->add_sequences(c.sequence());
    } else if (m.has_trigger()) {
      ++triggers;
      auto& update = *reply.mutable_transform_update();
      update.set_revision(7);
      *update.mutable_anchor() = to_proto(SessionKey{"rover", sessions.back()});
      auto& placed = *update.add_sessions();
      *placed.mutable_session() = update.anchor();
      *placed.mutable_t_component_session() = to_proto(pose_from_yaw(1, {1, 2, 3}));
    } else if (m.has_goodbye()) {
      complete = m.goodbye().complete();
      return true;
    } else {
      return true;
    }
    return send(socket, reply);
  }

  static bool send(tcp::socket& socket, const v1::ServerMessage& reply) {
    std::string frame;
    EXPECT_TRUE(append_frame(frame, reply.SerializeAsString()));
    boost::system::error_code code;
    boost::asio::write(socket, boost::asio::buffer(frame), code);
    return !code;
  }

  boost::asio::io_context io_;
  tcp::acceptor acceptor_{io_, {boost::asio::ip::make_address("127.0.0.1"), 0}};
  std::map<std::uint64_t, std::string> partial_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// A straight drift, 5 m wide, seen from its middle.
Points drift_scan() {
  Points points;
  for (int i = 0; i < 12000; ++i) {
    const float x = 20 * std::sin(0.37F * static_cast<float>(i)), s = 2.5F * std::sin(1.91F * static_cast<float>(i));
    const float side = i % 2 == 0 ? 2.5F : -2.5F;
    points.emplace_back(i % 4 < 2 ? Eigen::Vector3f(x, side, s) : Eigen::Vector3f(x, s, side));
  }
  return points;
}

class RobotClientTest : public testing::Test {
 protected:
  RobotConfig config(std::uint16_t port) const {
    RobotConfig c;
    c.robot = "rover";
    c.spool = folder_.path();
    c.host = "127.0.0.1";
    c.port = port;
    c.insecure = true;
    return c;
  }

  /// 31 scans, 1 m apart.
  static std::size_t drive(RobotClient& robot, const std::vector<float>& intensity = {}) {
    const Points scan = drift_scan();
    std::size_t keyframes = 0;
    for (int i = 0; i <= 30; ++i) {
      const auto added = robot.add_scan(i * 0.5, pose_from_yaw(0, {static_cast<double>(i), 0, 0}), scan, intensity);
      EXPECT_TRUE(added) << added.error().message;
      if (added && *added) ++keyframes;
    }
    return keyframes;
  }

  TempDir folder_;
};

#ifdef HEADFRAME_NETWORKS
TEST_F(RobotClientTest, ALidarThatTheNetworkNeverSawWorksAndIsSaidOnce) {
  ScriptedStation station;
  station.start();
  RobotConfig c = config(station.port());
  c.family = "learned";
  const auto robot = RobotClient::open(c);
  ASSERT_TRUE(robot) << robot.error().message;
  const auto beams_within = [](int deg) {  // of a round room
    Points points;
    for (int elevation = -deg; elevation <= deg; ++elevation)
      for (int azimuth = 0; azimuth < 360; ++azimuth) {
        const float a = static_cast<float>(azimuth) / 57.3F, e = static_cast<float>(elevation) / 57.3F;
        points.emplace_back(4 * std::cos(a), 4 * std::sin(a), 4 * std::tan(e));
      }
    return points;
  };
  const Points usual = beams_within(20), narrow = beams_within(2);
  EXPECT_TRUE((*robot)->add_scan(1, Pose::Identity(), usual).value());
  EXPECT_TRUE((*robot)->warnings().empty());
  EXPECT_TRUE((*robot)->add_scan(2, pose_from_yaw(0, {20, 0, 0}), narrow).value()) << "it works all the same";
  EXPECT_TRUE((*robot)->add_scan(3, pose_from_yaw(0, {40, 0, 0}), narrow).value());
  const auto warnings = (*robot)->warnings();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("that learned looks at"), std::string::npos) << warnings[0];
}
#endif

TEST_F(RobotClientTest, EverythingArrivesThoughTheLinkBreaksWithinACloud) {
  std::string session;
  std::size_t made = 0;
  ScriptedStation station;
  station.drop_after_chunks = 3;
  station.start();
  {
    const auto robot = RobotClient::open(config(station.port()));
    ASSERT_TRUE(robot) << robot.error().message;
    session = (*robot)->session().session;
    std::uint64_t told = 0;
    std::mutex mutex;
    (*robot)->on_transform([&](const Transforms& t) {
      const std::lock_guard<std::mutex> lock(mutex);
      told = t.revision;
    });
    made = drive(**robot);
    const auto done = (*robot)->finish(20s);
    ASSERT_TRUE(done) << done.error().message;
    const auto p = (*robot)->progress();
    EXPECT_EQ(p.keyframes, made);
    EXPECT_EQ(p.keyframes_acknowledged, made);
    EXPECT_EQ(p.clouds_acknowledged, made);
    EXPECT_EQ(p.clouds_waiting, 0U);
    EXPECT_FALSE((*robot)->add_scan(1000, Pose::Identity(), drift_scan())) << "after finish()";
    (*robot)->close();
    const std::lock_guard<std::mutex> lock(mutex);
    EXPECT_EQ(told, 7U);
  }
  {
    const auto again = RobotClient::open(config(station.port()));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ((*again)->session().session, session);
    EXPECT_EQ(drive(**again), 0U) << "the same scans add nothing";
    EXPECT_TRUE((*again)->finish(20s));
    EXPECT_LT((*again)->progress().bytes_sent, 500U) << "nothing is sent twice";
  }
  EXPECT_EQ(station.connections, 3);
  EXPECT_EQ(station.sessions, std::vector<std::string>(3, session));
  EXPECT_GE(station.triggers, 1);
  EXPECT_TRUE(station.complete);
  ASSERT_EQ(station.keyframes.size(), made);
  // Thresholds: the mean range in this drift is over 10 m, so keyframes are 10 m apart.
  EXPECT_EQ(made, 4U);
  for (std::size_t i = 0; i < made; ++i) {
    const Keyframe& k = station.keyframes[i];
    EXPECT_EQ(k.sequence, i + 1);
    ASSERT_TRUE(station.clouds.count(k.sequence));
    const KeyframeCloud& cloud = station.clouds[k.sequence];
    EXPECT_EQ(point_count(cloud), k.point_count);
    EXPECT_EQ(cloud.sweeps.size(), i == 0 ? 1U : 10U) << "the sweeps on the way and its own scan";
    EXPECT_TRUE(cloud.sweeps.back().origin.isZero());
    EXPECT_GT(std::count_if(k.walls.code.begin(), k.walls.code.end(), [](auto c) { return c != 0; }), 50);
  }
}

TEST_F(RobotClientTest, IntensitiesArriveWhereTheyAreWantedAndCanBeRead) {
  const struct {
    const char* capability;
    bool wanted, arrive;
  } cases[] = {{"cloud_form_3", true, true}, {"cloud_form_2", true, false}, {"cloud_form_3", false, false}};
  for (const auto& one : cases) {
    ScriptedStation station;
    station.capabilities = {one.capability};
    station.start();
    const TempDir folder;
    RobotConfig c = config(station.port());
    c.spool = folder.path();
    c.intensity = one.wanted;
    {
      const auto robot = RobotClient::open(c);
      ASSERT_TRUE(robot) << robot.error().message;
      ASSERT_EQ(drive(**robot, std::vector<float>(drift_scan().size(), 0.25F)), 4U);
      ASSERT_TRUE((*robot)->finish(20s));
    }
    ASSERT_EQ(station.clouds.size(), 4U);
    for (const auto& [sequence, cloud] : station.clouds)
      for (const Sweep& sweep : cloud.sweeps) {
        ASSERT_EQ(sweep.intensity.size(), one.arrive ? sweep.points.size() : 0);
        for (const int value : sweep.intensity) EXPECT_NEAR(value, 64, 4);
      }
  }
}

/// All keyframes that there are, turned and moved.
std::vector<KeyframePose> moved_poses(std::uint64_t keyframes) {
  std::vector<KeyframePose> poses;
  for (std::uint64_t s = 1; s <= keyframes; ++s)
    poses.push_back({s, pose_from_yaw(0.5, {50, 10.0 * static_cast<double>(s), 0})});
  return poses;
}

TEST_F(RobotClientTest, NewPosesArriveBehindTheirKeyframesAlsoAfterARestart) {
  ScriptedStation station;
  station.capabilities = {"poses"};
  {
    const auto robot = RobotClient::open(config(1));  // nobody is there yet
    ASSERT_TRUE(robot) << robot.error().message;
    ASSERT_EQ(drive(**robot), 4U);
    EXPECT_EQ((*robot)->last_keyframe(), 4U);
    ASSERT_TRUE((*robot)->update_poses(moved_poses(4)));
    const auto nobody = (*robot)->update_poses(moved_poses(5));
    ASSERT_FALSE(nobody);
    EXPECT_EQ(nobody.error().code, ErrorCode::invalid_argument);
    // 40 m up the y axis: known ground, as the keyframes lie now; along x from (50, 0) on it is not.
    EXPECT_FALSE((*robot)->add_scan(100, pose_from_yaw(0.5, {50.5, 40, 0}), drift_scan()).value());
    EXPECT_TRUE((*robot)->add_scan(101, pose_from_yaw(0.5, {50, 60, 0}), drift_scan()).value());
    EXPECT_EQ((*robot)->progress().pose_updates, 1U);
  }
  station.start();
  const auto robot = RobotClient::open(config(station.port()));
  ASSERT_TRUE(robot) << robot.error().message;
  EXPECT_FALSE((*robot)->add_scan(102, pose_from_yaw(0.5, {50.5, 30, 0}), drift_scan()).value());
  const auto done = (*robot)->finish(20s);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ((*robot)->progress().pose_updates_acknowledged, 1U);
  EXPECT_FALSE((*robot)->progress().pose_updates_unsupported);
  (*robot)->close();
  ASSERT_EQ(station.keyframes.size(), 5U);
  EXPECT_EQ(station.keyframes_then, std::vector<std::uint64_t>{4}) << "behind its keyframes, ahead of what came later";
  ASSERT_EQ(station.moved.size(), 4U);
  EXPECT_TRUE(station.moved[3].isApprox(moved_poses(4)[2].T_local_sensor));
  EXPECT_FALSE((*robot)->update_poses(moved_poses(4))) << "the session is finished";
}

TEST_F(RobotClientTest, ACorrectedTrajectoryMovesWhatItMovesOnceAndSelectionGoesOnFromThere) {
  std::vector<TrajectoryPose> corrected;  // the drive went up the y axis
  corrected.reserve(31);
  for (int i = 0; i <= 30; ++i) corrected.push_back({i * 0.5, pose_from_yaw(M_PI / 2, {0, static_cast<double>(i), 0})});
  for (const bool again : {false, true}) {
    const auto robot = RobotClient::open(config(1));
    ASSERT_TRUE(robot) << robot.error().message;
    if (!again) {
      ASSERT_EQ(drive(**robot), 4U);
    }
    const auto done = (*robot)->correct(corrected);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->matched, 4U);
    EXPECT_EQ(done->moved.size(), again ? 0U : 4U);
    EXPECT_EQ((*robot)->progress().pose_updates, 1U);
    EXPECT_FALSE((*robot)->add_scan(100, pose_from_yaw(M_PI / 2, {0.5, 20, 0}), drift_scan()).value());
    EXPECT_EQ((*robot)->correct(std::vector<TrajectoryPose>{{1000, Pose::Identity()}})->matched, 0U);
    if (!again) continue;
    corrected[1].stamp_s = corrected[0].stamp_s;
    EXPECT_EQ((*robot)->correct(corrected).error().code, ErrorCode::invalid_argument);
    EXPECT_TRUE((*robot)->add_scan(101, pose_from_yaw(0, {20, 0, 0}), drift_scan()).value()) << "nobody drove there";
  }
}

TEST_F(RobotClientTest, AServerOfBeforePoseUpdatesGetsAllElseAndANewerOneThoseThatWaited) {
  {
    ScriptedStation station;
    station.capabilities = {"live"};
    station.start();
    const auto robot = RobotClient::open(config(station.port()));
    ASSERT_TRUE(robot) << robot.error().message;
    ASSERT_EQ(drive(**robot), 4U);
    ASSERT_TRUE((*robot)->update_poses(moved_poses(4)));
    ASSERT_TRUE((*robot)->finish(20s));
    EXPECT_TRUE((*robot)->progress().pose_updates_unsupported);
    EXPECT_EQ((*robot)->progress().pose_updates_acknowledged, 0U);
    (*robot)->close();
    EXPECT_TRUE(station.moved.empty());
    EXPECT_EQ(station.keyframes.size(), 4U);
  }
  ScriptedStation newer;
  newer.capabilities = {"live", "poses"};
  newer.start();
  const auto robot = RobotClient::open(config(newer.port()));
  ASSERT_TRUE(robot) << robot.error().message;
  ASSERT_TRUE((*robot)->finish(20s));
  (*robot)->close();
  EXPECT_EQ(newer.moved.size(), 4U);
}

TEST_F(RobotClientTest, OneIntensityTooManyOrTooFewIsAnError) {
  const auto robot = RobotClient::open(config(1));
  ASSERT_TRUE(robot);
  const Points scan = drift_scan();
  for (const std::size_t n : {scan.size() - 1, scan.size() + 1, std::size_t{1}}) {
    const auto added = (*robot)->add_scan(1, Pose::Identity(), scan, std::vector<float>(n, 1));
    ASSERT_FALSE(added) << n;
    EXPECT_EQ(added.error().code, ErrorCode::invalid_argument);
  }
  EXPECT_TRUE((*robot)->add_scan(1, Pose::Identity(), scan, std::vector<float>(scan.size(), 1)).value());
}

TEST_F(RobotClientTest, ARefusedCloudIsDroppedWithAWordAndAllElseArrives) {
  ScriptedStation station;
  station.refused_cloud = 2;
  station.start();
  {
    const auto robot = RobotClient::open(config(station.port()));
    ASSERT_TRUE(robot) << robot.error().message;
    ASSERT_EQ(drive(**robot), 4U);
    const auto done = (*robot)->finish(20s);
    ASSERT_TRUE(done) << done.error().message;
    const auto p = (*robot)->progress();
    EXPECT_EQ(p.clouds_acknowledged, 3U);
    EXPECT_EQ(p.clouds_refused, 1U);
    EXPECT_EQ(p.clouds_dropped, 1U);
    EXPECT_EQ(p.cloud_error, "cloud of keyframe 2 was refused: it is damaged");
    EXPECT_EQ(p.link_error, "") << "the link stays";
    EXPECT_FALSE(p.refused);
  }
  const auto again = RobotClient::open(config(station.port()));
  ASSERT_TRUE(again);
  EXPECT_TRUE((*again)->finish(20s)) << "it is not tried again";
  EXPECT_EQ((*again)->progress().clouds_dropped, 1U);
}

TEST_F(RobotClientTest, WithoutAServerNothingIsLost) {
  std::uint16_t port = 0;
  {
    ScriptedStation gone;
    gone.start();
    port = gone.port();
  }
  {
    const auto robot = RobotClient::open(config(port));
    ASSERT_TRUE(robot);
    EXPECT_EQ(drive(**robot), 4U);
    const auto done = (*robot)->finish(300ms);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::unavailable);
    EXPECT_NE(done.error().message.find("127.0.0.1:" + std::to_string(port)), std::string::npos)
        << done.error().message;
  }
  ScriptedStation station;
  station.start();
  {
    const auto robot = RobotClient::open(config(station.port()));
    ASSERT_TRUE(robot);
    const auto done = (*robot)->finish(20s);
    ASSERT_TRUE(done) << done.error().message;
  }
  EXPECT_EQ(station.keyframes.size(), 4U);
  EXPECT_EQ(station.clouds.size(), 4U);
}

TEST_F(RobotClientTest, ARefusalIsFinal) {
  ScriptedStation station;
  station.refusal.set_kind(v1::ERROR_KIND_REFUSED);
  station.refusal.set_message("another spool feeds this session");
  station.refusal.set_permanent(true);
  station.start();
  {
    const auto robot = RobotClient::open(config(station.port()));
    ASSERT_TRUE(robot);
    const auto done = (*robot)->finish(20s);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::refused);
    EXPECT_NE(done.error().message.find("another spool"), std::string::npos);
  }
  EXPECT_EQ(station.connections, 1);
}

TEST_F(RobotClientTest, OwnDescriptorsAreTakenAsTheyAre) {
  ScriptedStation station;
  station.start();
  {
    RobotConfig c = config(station.port());
    c.own_descriptors = OwnDescriptors{{"mine", 3}, 2, 1};
    const auto robot = RobotClient::open(c);
    ASSERT_TRUE(robot);
    EXPECT_FALSE((*robot)->add_scan(1, Pose::Identity(), drift_scan()));
    EXPECT_FALSE((*robot)->add_keyframe(1, Pose::Identity(), {{1}, {1}, {}}, {}));
    EXPECT_TRUE((*robot)->add_keyframe(1, Pose::Identity(), {{1, 2}, {3}, PlaceClass::junction}, {}).value());
    EXPECT_FALSE((*robot)->add_keyframe(1, Pose::Identity(), {{1, 2}, {3}, {}}, {}).value()) << "a repeat";
    EXPECT_TRUE((*robot)->finish(20s));
  }
  ASSERT_EQ(station.keyframes.size(), 1U);
  EXPECT_EQ(station.keyframes[0].descriptor.q, (std::vector<float>{1, 2}));
  EXPECT_EQ(station.keyframes[0].descriptor.place_class, PlaceClass::junction);
  EXPECT_TRUE(station.clouds.empty());
}

TEST_F(RobotClientTest, AScanWithoutAPointLosesOnlyItself) {
  const auto robot = RobotClient::open(config(1));
  ASSERT_TRUE(robot);
  const float nan = std::nanf("");
  const auto empty = (*robot)->add_scan(1, Pose::Identity(), {{nan, 0, 0}, {0, 0, 0}});
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::bad_input);
  Pose bad = Pose::Identity();
  bad.translation().x() = std::nan("");
  EXPECT_EQ((*robot)->add_scan(2, bad, drift_scan()).error().code, ErrorCode::invalid_argument);
  EXPECT_TRUE((*robot)->add_scan(3, Pose::Identity(), drift_scan()).value());
}

TEST_F(RobotClientTest, WithoutCredentialItSaysHowToGetOne) {
  RobotConfig c = config(1);
  c.insecure = false;
  const auto robot = RobotClient::open(c);
  ASSERT_FALSE(robot);
  EXPECT_NE(robot.error().message.find("headframe robot add"), std::string::npos) << robot.error().message;
}

}  // namespace
}  // namespace headframe
