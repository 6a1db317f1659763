#include "tests/bench/link/drive.hpp"

#include <cmath>
#include <random>

namespace headframe::bench {
namespace {

constexpr std::size_t q_size = 60, w_size = 60;

/// A drift of rough walls: ranges are noise around 4 m, so no two places match.
Points scan(std::mt19937& random, int points) {
  std::uniform_real_distribution<float> azimuth(0, 6.2831853F), range(3.0F, 12.0F), height(-1.4F, 1.6F);
  Points scan;
  scan.reserve(static_cast<std::size_t>(points));
  for (int i = 0; i < points; ++i) {
    const float a = azimuth(random), r = range(random);
    scan.emplace_back(r * std::cos(a), r * std::sin(a), height(random));
  }
  return scan;
}

std::vector<float> numbers(std::mt19937& random, std::size_t size) {
  std::uniform_real_distribution<float> value(0, 1);
  std::vector<float> out(size);
  for (float& v : out) v = value(random);
  return out;
}

}  // namespace

RobotConfig drive_config(const std::string& robot, const std::filesystem::path& spool, const std::string& host,
                         std::uint16_t port, const std::string& enrolment) {
  RobotConfig config;
  config.robot = robot;
  config.spool = spool;
  config.host = host;
  config.port = port;
  config.insecure = enrolment.empty();
  config.enrolment = enrolment;
  config.sensor = {"drawn-32", 32, 22.5F, 22.5F, 60.0F};
  config.own_descriptors = OwnDescriptors{{"bench_noise", 1}, q_size, w_size};
  config.clouds = CloudPolicy::all;
  return config;
}

Result<bool> add_drive_keyframe(RobotClient& client, const std::string& robot, std::uint64_t number, int points) {
  std::seed_seq seed(robot.begin(), robot.end());
  std::vector<std::uint32_t> words(1);
  seed.generate(words.begin(), words.end());
  std::mt19937 random(words[0] + static_cast<std::uint32_t>(number) * 2654435761U);
  const double s = static_cast<double>(number);
  const Pose T_local_sensor = pose_from_yaw(0.01 * s, {0.5 * s, std::sin(0.1 * s), 0});
  const Descriptor descriptor{numbers(random, q_size), numbers(random, w_size), PlaceClass::tunnel};
  return client.add_keyframe(s, T_local_sensor, descriptor, scan(random, points));
}

}  // namespace headframe::bench
