// Peers' bytes, spoilt at random but the same way each time: 100,000 inputs for each reader. HEADFRAME_MUTATIONS sets
// another number, for longer runs under the sanitizers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>

#include "common/wire/limits.hpp"
#include "server/net/robot_protocol.hpp"
#include "server/operator/router.hpp"
#include "tests/support/fake_station.hpp"
#include "tests/support/next_event.hpp"
#include "tests/support/robot_bytes.hpp"

namespace headframe {
namespace {

int mutations() {
  const char* wanted = std::getenv("HEADFRAME_MUTATIONS");
  return wanted != nullptr ? std::atoi(wanted) : 100'000;
}

class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}

  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  /// One to four changes: a bit flipped, bytes cut out, repeated, overwritten or put in from elsewhere.
  std::string spoil(std::string bytes, const std::string& other) {
    for (std::size_t i = below(4) + 1; i > 0 && !bytes.empty(); --i) {
      const std::size_t at = below(bytes.size()), n = below(std::min<std::size_t>(bytes.size() - at, 64)) + 1;
      switch (below(6)) {
        case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8))); break;
        case 1: bytes.erase(at, n); break;
        case 2: bytes.insert(at, bytes.substr(at, n)); break;
        case 3: bytes.replace(at, n, n, static_cast<char>(below(256))); break;
        case 4: bytes.insert(at, other.substr(below(other.size()), n)); break;
        default: bytes.resize(at); break;
      }
    }
    return bytes;
  }

 private:
  std::mt19937 random_;
};

/// A frame around a payload that was spoilt: what gets past the length.
std::string framed(const std::string& payload) {
  std::string out;
  (void)append_frame(out, payload);
  return out;
}

struct Robot {
  std::string hello = hello_frame(), cloud = small_cloud();
  std::vector<std::string> frames{keyframe_frame(line_keyframe(1)),
                                  keyframe_frame(line_keyframe(2)),
                                  chunk_frame(1, cloud.size(), 0, cloud),
                                  chunk_frame(2, cloud.size(), 0, cloud.substr(0, 100)),
                                  poses_frame(1, 2, 0, {{1, Pose::Identity()}, {2, Pose::Identity()}}),
                                  goodbye_frame(true),
                                  hello};
};

/// What the events may say, whatever the bytes were.
void expect_sound(const std::vector<RobotEvent>& events, std::uint64_t& keyframes) {
  for (const RobotEvent& event : events) {
    if (const auto* keyframe = std::get_if<KeyframeReceived>(&event)) {
      const std::uint64_t sequence = keyframe->keyframe.sequence;
      EXPECT_TRUE(sequence >= 1 && sequence <= keyframes + 1) << "the next one, or a repeat";
      keyframes = std::max(keyframes, sequence);
      EXPECT_TRUE(keyframe->keyframe.T_local_sensor.matrix().allFinite());
    }
    if (const auto* update = std::get_if<PosesReceived>(&event)) {
      EXPECT_TRUE(update->poses.front().sequence >= 1 && update->poses.back().sequence <= keyframes);
      for (const KeyframePose& pose : update->poses) EXPECT_TRUE(pose.T_local_sensor.matrix().allFinite());
    }
    if (const auto* cloud = std::get_if<CloudReceived>(&event)) {
      EXPECT_TRUE(cloud->sequence >= 1 && cloud->sequence <= keyframes);
      EXPECT_TRUE(decode_cloud(cloud->encoded));
    }
  }
}

TEST(Mutation, RobotsBytesGiveSoundEventsOrATypedError) {
  Mutator mutator(1);
  const Robot robot;
  int ended = 0, admitted = 0;
  const int inputs = mutations();
  for (int i = 0; i < inputs; ++i) {
    RobotProtocol protocol({}, {});
    const bool after_hello = mutator.below(4) != 0;
    std::string bytes = after_hello ? "" : robot.hello;
    for (std::size_t n = mutator.below(4); n > 0; --n) bytes += robot.frames[mutator.below(robot.frames.size())];
    const std::string& other = robot.frames[mutator.below(robot.frames.size())];
    if (mutator.below(2) == 0)
      bytes = mutator.spoil(bytes, other);
    else
      bytes += framed(mutator.spoil(other.substr(4), robot.hello));
    if (after_hello) bytes.insert(0, robot.hello);
    std::uint64_t keyframes = 0;
    for (std::size_t at = 0, piece = mutator.below(bytes.size() + 1) + 1; at < bytes.size(); at += piece) {
      protocol.receive(std::string_view(bytes).substr(at, piece), {});
      std::vector<RobotEvent> events;
      while (auto event = next_event(protocol)) {
        if (std::holds_alternative<HelloReceived>(*event)) protocol.welcome({});
        events.push_back(std::move(*event));
      }
      expect_sound(events, keyframes);
    }
    admitted += protocol.welcomed() ? 1 : 0;
    const std::string output = protocol.take_output();
    EXPECT_LT(output.size(), 2 * limits::frame_bytes);
    if (!protocol.ended()) continue;
    ++ended;
    ASSERT_FALSE(messages(output).empty()) << "it says why";
    EXPECT_TRUE(messages(output).back().has_error());
    protocol.receive(robot.hello, {});
    EXPECT_FALSE(protocol.next()) << "nothing is read after the end";
  }
  EXPECT_GT(ended, inputs / 10) << "the inputs must reach both outcomes";
  EXPECT_GT(admitted, inputs / 10);
}

TEST(Mutation, RequestsGetAnAnswerAndOnlyTheirOwnChangesHappen) {
  Mutator mutator(2);
  FakeStation station;
  const std::vector<std::string> targets{"/healthz",
                                         "/api/v1/status",
                                         "/api/v1/sessions",
                                         "/api/v1/atlas?wait=1",
                                         "/api/v1/merge",
                                         "/api/v1/export?component=1&format=ply&voxel=0.5",
                                         "/api/v1/trajectory?robot=alpha&session=run%2F1",
                                         "/api/v1/robots/add?robot=a",
                                         "/api/v1/explain?a=alpha/run&b=beta/run",
                                         "/api/v1/alignments/1/confirm"};
  PointTiles tiles(station);
  const std::set<std::string> open_to_all{"/healthz", "/readyz", "/", "/index.html", "/api/v1/openapi.json"};
  int answered = 0, refused = 0;
  const int inputs = mutations();
  for (int i = 0; i < inputs; ++i) {
    const std::string& whole = targets[mutator.below(targets.size())];
    const std::string target =
        mutator.below(5) == 0 ? whole : mutator.spoil(whole, targets[mutator.below(targets.size())]);
    const int merges = station.merges;
    const Reply reply = route({"GET", target}, station, tiles, OperatorLimits{}, 1);
    EXPECT_EQ(station.merges, merges) << "a GET changes nothing: " << target;
    const auto* ready = std::get_if<Ready>(&reply);
    ++(ready != nullptr && ready->status >= 400 ? refused : answered);
    if (ready == nullptr || ready->status < 400) continue;
    EXPECT_TRUE(ready->status == 400 || ready->status == 403 || ready->status == 404 || ready->status == 405)
        << ready->status << " " << target;
    EXPECT_EQ(ready->body.find('\n'), ready->body.size() - 1) << "one line of JSON";
    EXPECT_TRUE(!is_public(target) || open_to_all.contains(target.substr(0, target.find('?')))) << target;
  }
  EXPECT_GT(answered, inputs / 10);
  EXPECT_GT(refused, inputs / 10);
}

TEST(Mutation, FramesAreCutTheSameHoweverTheyCome) {
  Mutator mutator(3);
  const Robot robot;
  const int inputs = mutations() / 10;
  for (int i = 0; i < inputs; ++i) {
    std::string bytes;
    for (std::size_t n = mutator.below(3) + 1; n > 0; --n) bytes += robot.frames[mutator.below(robot.frames.size())];
    bytes = mutator.spoil(bytes, robot.hello);
    const auto cut = [&](std::size_t piece) {
      FrameReader reader;
      std::vector<std::string> payloads;
      for (std::size_t at = 0; at < bytes.size(); at += piece) {
        reader.feed(std::string_view(bytes).substr(at, piece));
        for (auto next = reader.next(); next && *next; next = reader.next()) payloads.push_back(**next);
      }
      return payloads;
    };
    EXPECT_EQ(cut(bytes.size() + 1), cut(mutator.below(bytes.size() + 1) + 1));
  }
}

}  // namespace
}  // namespace headframe
