#pragma once
// LAS 1.2, point format 3 (coordinates, intensity, time and colour), for survey software. Pure.

#include <array>
#include <cstdint>
#include <string>

#include "common/geometry/se3.hpp"

namespace headframe {

constexpr double las_unit_m = 0.001;  // the unit of coordinates: 32-bit integers relative to the header's offset
constexpr std::uint16_t las_point_bytes = 34;

struct LasHead {
  std::uint32_t points = 0;
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(),
                  max_m = Eigen::Vector3d::Zero();  // bounds of all points as written
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  std::uint16_t source = 0;   // file source id
  std::int64_t made_s = 0;    // since the epoch
  bool has_gps_time = false;  // times are adjusted GPS time; else they count from the robot's own start
};

struct LasPoint {
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();  // within 2000 km of the offset
  std::array<std::uint8_t, 3> colour{};
  std::uint16_t source = 0;  // the session that saw it, numbered from 1
  double time_s = 0;
  std::uint8_t intensity = 0;  // 0: unknown
};

/// The 227 bytes before the points.
std::string las_header(const LasHead& head);

void append_las_point(std::string& out, const LasPoint& point, const Eigen::Vector3d& offset_m);

/// The position that is read back after writing: rounded to whole units from the offset.
Eigen::Vector3d las_place(const Eigen::Vector3d& p_m, const Eigen::Vector3d& offset_m);

/// Adjusted GPS time (GPS seconds minus 1e9) from seconds since 1970 by a UTC clock.
double adjusted_gps_s(double unix_s);

}  // namespace headframe
