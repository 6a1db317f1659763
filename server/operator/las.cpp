#include "server/operator/las.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "server/operator/append_bytes.hpp"

namespace headframe {
namespace {

void append_name(std::string& out, std::string name) {
  name.resize(32, '\0');
  out += name;
}

std::array<std::int32_t, 3> units(const Eigen::Vector3d& p_m, const Eigen::Vector3d& offset_m) {
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  std::array<std::int32_t, 3> out{};
  for (int axis = 0; axis < 3; ++axis)
    out.at(static_cast<std::size_t>(axis)) =
        static_cast<std::int32_t>(std::lround(std::clamp((p_m[axis] - offset_m[axis]) / las_unit_m, -most, most)));
  return out;
}

}  // namespace

std::string las_header(const LasHead& head) {
  constexpr std::uint16_t header_bytes = 227;
  const auto made = static_cast<std::time_t>(head.made_s);
  std::tm day{};
  ::gmtime_r(&made, &day);
  std::string out = "LASF";
  append_bytes(out, head.source);
  append_bytes(out, static_cast<std::uint16_t>(head.has_gps_time ? 1 : 0));
  out.append(16, '\0');  // project
  append_bytes(out, std::uint8_t{1});
  append_bytes(out, std::uint8_t{2});
  append_name(out, "MERGE");
  append_name(out, "headframe");
  append_bytes(out, static_cast<std::uint16_t>(day.tm_yday + 1));
  append_bytes(out, static_cast<std::uint16_t>(day.tm_year + 1900));
  append_bytes(out, header_bytes);
  append_bytes(out, std::uint32_t{header_bytes});
  append_bytes(out, std::uint32_t{0});  // variable length records
  append_bytes(out, std::uint8_t{3});
  append_bytes(out, las_point_bytes);
  append_bytes(out, head.points);
  append_bytes(out, head.points);  // by return: all are first returns
  out.append(4 * sizeof(std::uint32_t), '\0');
  for (int axis = 0; axis < 3; ++axis) append_bytes(out, las_unit_m);
  for (int axis = 0; axis < 3; ++axis) append_bytes(out, head.offset_m[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    append_bytes(out, head.max_m[axis]);
    append_bytes(out, head.min_m[axis]);
  }
  return out;
}

void append_las_point(std::string& out, const LasPoint& point, const Eigen::Vector3d& offset_m) {
  for (const std::int32_t value : units(point.p_m, offset_m)) append_bytes(out, value);
  append_bytes(out, static_cast<std::uint16_t>(point.intensity * 257));  // scales 8 bits to 16, as for colours
  append_bytes(out, std::uint8_t{0x09});                                 // first of one return
  out.append(3, '\0');                                                   // class, angle, user data
  append_bytes(out, point.source);
  append_bytes(out, point.time_s);
  for (const std::uint8_t channel : point.colour) append_bytes(out, static_cast<std::uint16_t>(channel * 257));
}

Eigen::Vector3d las_place(const Eigen::Vector3d& p_m, const Eigen::Vector3d& offset_m) {
  Eigen::Vector3d out = offset_m;
  const auto whole = units(p_m, offset_m);
  for (int axis = 0; axis < 3; ++axis) out[axis] += whole.at(static_cast<std::size_t>(axis)) * las_unit_m;
  return out;
}

double adjusted_gps_s(double unix_s) {
  constexpr double gps_epoch_s = 315964800;  // 6 January 1980
  // UTC falls one more second behind GPS at each of these times.
  constexpr std::array<double, 4> leaps{1230768000, 1341100800, 1435708800, 1483228800};
  double behind_s = 14;
  for (const double leap : leaps) behind_s += unix_s >= leap ? 1 : 0;
  return unix_s - gps_epoch_s + behind_s - 1e9;
}

}  // namespace headframe
