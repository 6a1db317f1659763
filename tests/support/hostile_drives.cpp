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

std::string keyframe_and_cloud(const Drive& drive, std::size_t i) {
  return keyframe_frame(drive.keyframes[i]) + cloud_frames(i + 1, encode_cloud(drive.clouds[i]).value());
}

/// All that a robot tells which drove so, and its goodbye.
std::string told(const Drive& drive) {
  std::string out;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i) out += keyframe_and_cloud(drive, i);
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

/// Forty times through the same twelve metres: every place is a loop with all the times before.
void to_and_fro(const HostileTarget& target) {
  static const std::string all = [] {
    std::vector<Eigen::Vector2d> corners;
    for (int i = 0; i <= 40; ++i) corners.emplace_back(i % 2 == 0 ? 2 : 14, 0);
    return told(drive(branches_mine(), corners, 0.2, 9));
  }();
  tell(target, all);
}

/// Where am I, after every keyframe and over and over, for its questions go before other work.
void asks_where_on_and_on(const HostileTarget& target) {
  static const std::string all = [] {
    v1::RobotMessage asks, takes_back;
    asks.mutable_localize();
    takes_back.mutable_localize()->set_stop(true);
    const Drive drive = drive_b_to_a();
    std::string frames;
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
      frames += keyframe_and_cloud(drive, i);
      for (int again = 0; again < 50; ++again) frames += frame(takes_back) + frame(asks);
    }
    return frames;
  }();
  tell(target, all);
}

/// The largest map in the finest cubes, paths and coverage, all of them anew each time.
void asks_for_maps_on_and_on(const HostileTarget& target) {
  static const std::string all = [] {
    const Drive drive = drive_b_to_a();
    std::string frames;
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) frames += keyframe_and_cloud(drive, i);
    for (std::uint64_t i = 1; i <= 500; ++i) {
      v1::RobotMessage map, paths, coverage;
      map.mutable_map_request()->set_id(i);
      map.mutable_map_request()->set_resolution_m(0.05F);
      map.mutable_map_request()->mutable_sphere()->set_radius_m(200);
      paths.mutable_trajectories_request();
      coverage.mutable_coverage_request();
      frames += frame(map) + frame(paths) + frame(coverage);
    }
    return frames;
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
      {"to and fro", to_and_fro},
      {"asks where on and on", asks_where_on_and_on},
      {"asks for maps on and on", asks_for_maps_on_and_on},
  };
  return acts;
}

}  // namespace headframe::test
