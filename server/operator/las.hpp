#pragma once
// LAS 1.2, point format 2 (coordinates and colour), for survey software. Pure.

#include <array>
#include <cstdint>
#include <string>

#include "common/geometry/se3.hpp"

namespace headframe {

constexpr double las_unit_m = 0.001;  // coordinates are 32-bit integers of this, counted from the header's offset
constexpr std::uint16_t las_point_bytes = 26;

/// The 227 bytes before the points; min and max are of all points (m).
std::string las_header(std::uint32_t points, const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m,
                       const Eigen::Vector3d& offset_m);

/// Appends a point within 2000 km of the offset.
void append_las_point(std::string& out, const Eigen::Vector3d& p_m, const Eigen::Vector3d& offset_m,
                      const std::array<std::uint8_t, 3>& colour);

}  // namespace headframe
