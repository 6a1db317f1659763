#include "server/operator/las.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace headframe {
namespace {

static_assert(std::endian::native == std::endian::little, "LAS is little-endian");

template <class T>
void append(std::string& out, T value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

void append_name(std::string& out, std::string name) {
  name.resize(32, '\0');
  out += name;
}

}  // namespace

std::string las_header(std::uint32_t points, const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m,
                       const Eigen::Vector3d& offset_m) {
  constexpr std::uint16_t header_bytes = 227;
  std::string out = "LASF";
  out.append(4 + 16, '\0');  // source, encoding, project
  append(out, std::uint8_t{1});
  append(out, std::uint8_t{2});
  append_name(out, "MERGE");
  append_name(out, "headframe");
  append(out, std::uint16_t{0});  // day and year of making: none, so that the same map is the same file
  append(out, std::uint16_t{0});
  append(out, header_bytes);
  append(out, std::uint32_t{header_bytes});
  append(out, std::uint32_t{0});  // variable length records
  append(out, std::uint8_t{2});
  append(out, las_point_bytes);
  append(out, points);
  append(out, points);  // of the first return
  out.append(4 * sizeof(std::uint32_t), '\0');
  for (int axis = 0; axis < 3; ++axis) append(out, las_unit_m);
  for (int axis = 0; axis < 3; ++axis) append(out, offset_m[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    append(out, max_m[axis]);
    append(out, min_m[axis]);
  }
  return out;
}

void append_las_point(std::string& out, const Eigen::Vector3d& p_m, const Eigen::Vector3d& offset_m,
                      const std::array<std::uint8_t, 3>& colour) {
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  for (int axis = 0; axis < 3; ++axis)
    append(out,
           static_cast<std::int32_t>(std::lround(std::clamp((p_m[axis] - offset_m[axis]) / las_unit_m, -most, most))));
  append(out, std::uint16_t{0});    // intensity
  append(out, std::uint8_t{0x09});  // the first return of one
  out.append(5, '\0');              // class, angle, user data, source
  for (const std::uint8_t channel : colour) append(out, static_cast<std::uint16_t>(channel * 257));
}

}  // namespace headframe
