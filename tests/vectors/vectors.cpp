#include "tests/vectors/vectors.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace headframe::vectors {
namespace {

float millimetres(double metres) { return static_cast<float>(std::round(metres * 1000) / 1000); }
double readable(float metres) { return std::round(static_cast<double>(metres) * 1000) / 1000; }

}  // namespace

std::vector<File> all_files() {
  std::vector<File> all = link_files();
  for (auto more : {place_files(), cloud_files()}) std::move(more.begin(), more.end(), std::back_inserter(all));
  return all;
}

std::string to_text(const Json& content) {
  std::string text = "{\n";
  for (const auto& [key, value] : content.items()) {
    if (text.size() > 2) text += ",\n";
    text += Json(key).dump() + ": ";
    if (!value.is_array() || value.empty() || !value.front().is_structured()) {
      text += value.dump();
      continue;
    }
    text += "[";
    for (std::size_t i = 0; i < value.size(); ++i) text += (i == 0 ? "\n  " : ",\n  ") + value[i].dump();
    text += "]";
  }
  return text + "\n}\n";
}

std::string difference(const Json& a, const Json& b) {
  const nlohmann::json flat_a = nlohmann::json(a).flatten(), flat_b = nlohmann::json(b).flatten();
  for (const auto& [pointer, value] : flat_a.items()) {
    if (!flat_b.contains(pointer)) return pointer + ": " + value.dump() + " against nothing";
    const Json& other = flat_b.at(pointer);
    if (value.is_number_float() && other.is_number()) {
      const double x = value, y = other;
      if (std::abs(x - y) <= 1e-6 + 1e-5 * std::abs(x)) continue;
    } else if (value == other) {
      continue;
    }
    return pointer + ": " + value.dump() + " against " + other.dump();
  }
  for (const auto& [pointer, value] : flat_b.items())
    if (!flat_a.contains(pointer)) return pointer + ": nothing against " + value.dump();
  return "";
}

Json to_json(const Points& points) {
  Json rows = Json::array();
  for (const auto& p : points) rows.push_back({readable(p.x()), readable(p.y()), readable(p.z())});
  return rows;
}

Json to_json(const Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  const Eigen::Vector3d t = T.translation();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Points room_scan(int columns, int beams) {
  const Eigen::Vector3d low(-3, -2.5, -1.2), high(3, 2.5, 2.1);
  Points points;
  for (int b = 0; b < beams; ++b)
    for (int c = 0; c < columns; ++c) {
      const double elevation = (-20 + 40 * (b + 0.5) / beams) * std::numbers::pi / 180;
      const double azimuth = 2 * std::numbers::pi * (c + 0.37) / columns;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      double range = 1e9;
      for (int axis = 0; axis < 3; ++axis)
        range = std::min(range, std::max(low[axis] / ray[axis], high[axis] / ray[axis]));
      if (azimuth > 0.4 && azimuth < 0.6) range = std::min(range, 1.5);  // the pillar
      const Eigen::Vector3d p = range * ray;
      points.emplace_back(millimetres(p.x()), millimetres(p.y()), millimetres(p.z()));
    }
  return points;
}

}  // namespace headframe::vectors
