#pragma once
// A keyframe as a robot sends it, and the session it belongs to.

#include <array>
#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include "common/geometry/se3.hpp"

namespace headframe {

/// One run of one robot in one local frame W_n. Names are chosen by the robot; together they are unique on a server.
struct SessionKey {
  std::string robot;
  std::string session;
  auto operator<=>(const SessionKey&) const = default;
};

/// A spinning lidar as sensor.json describes it. fov_*_deg are measured from the horizon, both positive.
struct Sensor {
  std::string model;
  int beams = 0;
  float fov_up_deg = 0;
  float fov_down_deg = 0;
  float max_range_m = 0;
};

/// Descriptors of different families or versions are never compared.
struct FamilyId {
  std::string name;
  int version = 0;
  auto operator<=>(const FamilyId&) const = default;
};

enum class PlaceClass : std::uint8_t { unknown = 0, tunnel = 1, junction = 2 };

/// q: place vector, independent of yaw. w: circular signature over azimuth (may be empty).
struct Descriptor {
  std::vector<float> q;
  std::vector<float> w;
  PlaceClass place_class = PlaceClass::unknown;
};

/// Horizontal distance to the nearest wall in each of 180 azimuth sectors (2 deg) of the levelled sensor frame, in
/// logarithmic steps (see wall_profile.hpp). It lets the server draw a 2D wall/free map of a session with no cloud.
struct WallProfile {
  static constexpr std::size_t sectors = 180;
  std::array<std::uint8_t, sectors> code{};  // 0: no return
};

/// A keyframe as it is sent. Sequence numbers of a session start at 1 and have no gaps.
struct Keyframe {
  std::uint64_t sequence = 0;
  double stamp_s = 0;  // the robot's clock
  Pose T_local_sensor = Pose::Identity();
  float spaciousness_m = 0;  // FRAME: s_k, smoothed mean range
  Descriptor descriptor;
  WallProfile walls;
  std::uint32_t point_count = 0;  // of its cloud; 0: no cloud
};

/// In the session's local frame, metres.
inline Eigen::Vector3d position(const Keyframe& keyframe) { return keyframe.T_local_sensor.translation(); }

}  // namespace headframe
