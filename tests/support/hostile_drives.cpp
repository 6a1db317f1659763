// Robots that were let in and whose odometry or lidar is broken, by malice or not.

#include <cmath>

#include "common/descriptor/family.hpp"
#include "tests/support/drawn_session.hpp"
#include "tests/support/tls_peer.hpp"

namespace headframe::test {
namespace {

FamilySpec drawn_family() {
  const Descriptor& any = drive_b_to_a(3).keyframes.front().descriptor;
  return {make_family(default_family_name).value()->id(), any.q.size(), any.w.size()};
}

/// All that a robot tells which drove so, and its goodbye.
std::string told(const Drive& drive) {
  std::string out;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
    out += keyframe_frame(drive.keyframes[i]) + cloud_frames(i + 1, encode_cloud(drive.clouds[i]).value());
  return out + goodbye_frame(true);
}

void tell(const HostileTarget& target, const std::string& all) {
  static const FamilySpec family = drawn_family();
  Accomplice robot(target, family);
  robot.send(all);
  robot.settle();
}

void far_poses(const HostileTarget& target) {
  static const std::string all = [] {
    Drive drive = drive_b_to_a();
    drive.keyframes.resize(2);
    for (Keyframe& keyframe : drive.keyframes) keyframe.T_local_sensor.translation() += Eigen::Vector3d(5e7, -5e7, 0);
    return told(drive);
  }();
  tell(target, all);
}

void flung_about(const HostileTarget& target) {
  static const std::string all = [] {
    Drive drive = drive_b_to_a();
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
      drive.keyframes[i].T_local_sensor.translation() *= std::pow(-7.0, static_cast<double>(i % 9));
    return told(drive);
  }();
  tell(target, all);
}

/// The odometry jumps among the corners of a square.
void jumps(const HostileTarget& target) {
  static const std::string all = [] {
    Drive drive = drive_b_to_a(3);
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
      drive.keyframes[i].T_local_sensor.translation() += Eigen::Vector3d(i % 2 == 0 ? 0 : 340, i % 4 < 2 ? 0 : 340, 0);
    return told(drive);
  }();
  tell(target, all);
}

/// Through twenty drifts one beside the other: a thousand metres that look alike everywhere.
Drive snake() {
  constexpr double length_m = 75, apart_m = 12;
  std::vector<Box> drifts;
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row < 18; ++row) {
    const double y = apart_m * row, from = row % 2 == 0 ? 2 : length_m - 2, to = length_m - from;
    drifts.push_back(BoxMine::drift(0, y, length_m, y));
    drifts.push_back(BoxMine::drift(to, y, to, y + apart_m));
    corners.emplace_back(from, y);
    corners.emplace_back(to, y);
  }
  return drive(BoxMine(drifts), corners, 0.4, 7);
}

void long_snake(const HostileTarget& target) {
  static const std::string all = told(snake());
  tell(target, all);
}

/// Carried 12 m up in the middle of the drive, into the same mine once more.
void kidnapped(const HostileTarget& target) {
  static const std::string all = [] {
    Drive drive = drive_a_to_c(3);
    for (std::size_t i = drive.keyframes.size() / 2; i < drive.keyframes.size(); ++i)
      drive.keyframes[i].T_local_sensor.translation().z() += 12;
    return told(drive);
  }();
  tell(target, all);
}

/// Stretched by a third: it fits nothing, and nearly everything.
void wrong_scale(const HostileTarget& target) {
  static const std::string all = [] {
    Drive drive = drive_b_to_a(3);
    for (Keyframe& keyframe : drive.keyframes) keyframe.T_local_sensor.translation() *= 1.3;
    return told(drive);
  }();
  tell(target, all);
}

Drive with_cloud(const Points& points) {
  Drive drive = drive_b_to_a(3);
  for (KeyframeCloud& cloud : drive.clouds) cloud.sweeps[0].points = points;
  return drive;
}

void no_returns_as_zeros(const HostileTarget& target) {
  static const std::string all = told(with_cloud(Points(30000, Eigen::Vector3f::Zero())));
  tell(target, all);
}

void one_point_many_times(const HostileTarget& target) {
  static const std::string all = [] {
    Drive drive = with_cloud(Points(3'900'000, Eigen::Vector3f(3, 1, 0)));
    drive.keyframes.resize(4);
    drive.clouds.resize(4);
    return told(drive);
  }();
  tell(target, all);
}

}  // namespace

const std::vector<HostileAct>& hostile_drives() {
  static const std::vector<HostileAct> acts{
      {"far poses", far_poses},
      {"flung about", flung_about},
      {"jumps among corners", jumps},
      {"long snake", long_snake},
      {"kidnapped", kidnapped},
      {"wrong scale", wrong_scale},
      {"no-returns as zeros", no_returns_as_zeros},
      {"one point many times", one_point_many_times},
  };
  return acts;
}

}  // namespace headframe::test
