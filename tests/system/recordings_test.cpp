// The recordings through the real programs: server, robots that replay, the operator's command. Skipped where they are
// absent.

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/base_station.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/truth.hpp"

namespace headframe::test {
namespace {

using namespace std::chrono_literals;

struct Placed {
  std::string component;
  Pose T_component_session = Pose::Identity();
};

Pose from_rows(const nlohmann::json& numbers) {
  Pose T = Pose::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = numbers.at(static_cast<std::size_t>(i));
  return T;
}

class Recordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(recordings()))
      GTEST_SKIP() << "no recordings at " << recordings() << "; set HEADFRAME_RECORDINGS";
  }

  /// All robots stream at once into a fresh server; where each ended up, by robot.
  std::map<std::string, Placed> run(const std::string& name, const std::vector<std::string>& robots) {
    const ScratchFolder scratch;
    auto station = BaseStation::start(scratch.path() / "data");
    if (!station) {
      ADD_FAILURE() << station.error().message;
      return {};
    }
    std::vector<Process> replays;
    replays.reserve(robots.size());
    for (const auto& robot : robots) replays.push_back(station->replay(robot, recordings() / name / robot).value());
    for (auto& replay : replays) {
      const auto ended = replay.wait(300s);
      EXPECT_TRUE(ended && ended->status == 0) << (ended ? ended->output : ended.error().message);
    }
    const auto atlas = station->settled_atlas();
    if (!atlas) {
      ADD_FAILURE() << atlas.error().message;
      return {};
    }
    std::map<std::string, Placed> placed;
    for (const auto& component : atlas->at("components"))
      for (const auto& session : component.at("sessions"))
        placed[session.at("robot")] = {component.at("id").dump(), from_rows(session.at("T_component_session"))};
    station->process().signal(SIGTERM);
    const auto ended = station->process().wait(30s);
    EXPECT_TRUE(ended && ended->status == 0) << "SIGTERM ends the server cleanly";
    return placed;
  }

  static void expect_near_truth(const std::string& name, const std::map<std::string, Placed>& placed, double most_m,
                                double most_deg) {
    for (auto a = placed.begin(); a != placed.end(); ++a)
      for (auto b = std::next(a); b != placed.end(); ++b) {
        EXPECT_EQ(a->second.component, b->second.component) << a->first << " and " << b->first;
        const Pose T_a_b = a->second.T_component_session.inverse() * b->second.T_component_session;
        const auto error = overlap_error(read_true_path(recordings() / name, a->first),
                                         read_true_path(recordings() / name, b->first), T_a_b);
        if (error.pairs == 0) continue;
        std::printf("%s %s-%s: %.3f m, %.2f deg over %zu pairs\n", name.c_str(), a->first.c_str(), b->first.c_str(),
                    error.translation_m, error.rotation_deg, error.pairs);
        EXPECT_LT(error.translation_m, most_m) << a->first << " and " << b->first;
        EXPECT_LT(error.rotation_deg, most_deg) << a->first << " and " << b->first;
      }
  }
};

TEST_F(Recordings, TunnelTwoMerges) {
  const auto placed = run("tunnel-two", {"r1", "r2"});
  ASSERT_EQ(placed.size(), 2U);
  expect_near_truth("tunnel-two", placed, 0.3, 1);
}

TEST_F(Recordings, TunnelFourBecomesOneComponent) {
  const auto placed = run("tunnel-four", {"s1", "s2", "s3", "s4"});
  ASSERT_EQ(placed.size(), 4U);
  expect_near_truth("tunnel-four", placed, 0.3, 1);
}

TEST_F(Recordings, TunnelApartStaysApart) {
  const auto placed = run("tunnel-apart", {"r1", "r2"});
  ASSERT_EQ(placed.size(), 2U);
  EXPECT_NE(placed.at("r1").component, placed.at("r2").component);
}

TEST_F(Recordings, CampusDriveMerges) {
  const auto placed = run("nclt-two-robots", {"a", "b"});
  ASSERT_EQ(placed.size(), 2U);
  expect_near_truth("nclt-two-robots", placed, 0.5, 1);
}

}  // namespace
}  // namespace headframe::test
