#include "server/operator/map_export.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <sstream>

#include "server/operator/las.hpp"

namespace headframe {
namespace {

static_assert(std::endian::native == std::endian::little, "points are written as they lie in memory");

constexpr std::array<std::array<std::uint8_t, 3>, 8> palette{{{230, 97, 1},
                                                              {31, 120, 180},
                                                              {51, 160, 44},
                                                              {170, 60, 200},
                                                              {227, 26, 28},
                                                              {0, 170, 170},
                                                              {200, 160, 0},
                                                              {120, 120, 120}}};

template <class T>
void append(std::string& out, T value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

/// Names are peers' bytes: a line break in one must not end the header's line.
std::string one_line(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '_');
  return name;
}

}  // namespace

Result<Component> find_component(const Atlas& atlas, SessionId id) {
  std::ostringstream there;
  for (const Component& component : atlas.components) {
    if (component.id == id) return component;
    there << (there.tellp() > 0 ? ", " : "") << component.id;
  }
  const std::string list = there.str();
  return failure(ErrorCode::not_found, "there is no component " + std::to_string(id) +
                                           (list.empty() ? "; the atlas is empty" : "; there are " + list));
}

Result<std::optional<std::string>> MapExport::next() {
  if (stage_ == Stage::start) {
    if (auto listed = list_keyframes(); !listed) return tl::unexpected(listed.error());
    stage_ = Stage::count;
    return std::string();
  }
  if (stage_ == Stage::count) {
    if (at_ < items_.size()) {
      if (auto counted = count(items_[at_++]); !counted) return tl::unexpected(counted.error());
      return std::string();
    }
    std::erase_if(items_, [](const Item& item) { return item.points == 0; });
    at_ = 0;
    stage_ = Stage::write;
    return header();
  }
  if (at_ == items_.size()) return std::nullopt;
  return written(items_[at_++]).map([](std::string piece) { return std::optional(std::move(piece)); });
}

Result<void> MapExport::list_keyframes() {
  const auto component = find_component(station_.atlas().atlas, request_.component);
  if (!component) return tl::unexpected(component.error());
  std::map<SessionId, std::string> robot_of;
  for (const SessionRow& row : station_.sessions()) robot_of[row.id] = row.key.robot;
  std::map<std::string, Colour> colours;
  for (const Placement& placement : component->placements) {
    const std::string& robot = robot_of[placement.session];
    const auto [colour, first] = colours.try_emplace(robot, palette[colours.size() % palette.size()]);
    if (first) {
      std::ostringstream line;
      line << "robot " << one_line(robot) << " colour";
      for (int channel : colour->second) line << ' ' << channel;
      legend_.push_back(line.str());
    }
    const auto keyframes = station_.trajectory(placement.session);
    if (!keyframes) return tl::unexpected(keyframes.error());
    for (const Keyframe& keyframe : *keyframes)
      items_.push_back({placement.session, keyframe.sequence, placement.T_component_session * keyframe.T_local_sensor,
                        colour->second, 0});
  }
  return {};
}

Result<void> MapExport::count(Item& item) {
  const auto points = thinned(item);
  if (points) {
    item.points = points->size();
    if (request_.format == CloudFormat::las)
      for (const Eigen::Vector3f& p_sensor : *points) box_m_.extend(item.T_component_sensor * p_sensor.cast<double>());
  } else if (points.error().code != ErrorCode::not_found) {  // a keyframe whose cloud is not stored is left out
    return tl::unexpected(points.error());
  }
  return {};
}

Result<Points> MapExport::thinned(const Item& item) const {
  const auto cloud = station_.cloud(item.session, item.sequence);
  if (!cloud) return tl::unexpected(cloud.error());
  Points points;
  points.reserve(point_count(*cloud));
  for (const Sweep& sweep : cloud->sweeps)
    for (const Eigen::Vector3f& p_sensor : sweep.points)
      if (p_sensor.allFinite()) points.push_back(p_sensor);
  return request_.voxel_m > 0 ? voxel_grid(points, static_cast<float>(request_.voxel_m)) : std::move(points);
}

Result<std::string> MapExport::written(const Item& item) const {
  const auto points = thinned(item);
  if (!points) return tl::unexpected(points.error());
  if (points->size() != item.points)
    return failure(ErrorCode::internal, "the cloud of keyframe " + std::to_string(item.sequence) + " of session " +
                                            std::to_string(item.session) + " changed during the export; start again");
  const bool ply = request_.format == CloudFormat::ply;
  const auto [red, green, blue] = item.colour;
  std::string out;
  out.reserve(points->size() * 26);
  for (const Eigen::Vector3f& p_sensor : *points) {
    const Eigen::Vector3d p_m = item.T_component_sensor * p_sensor.cast<double>();
    if (request_.format == CloudFormat::las) {
      append_las_point(out, p_m, item.colour);
      continue;
    }
    const Eigen::Vector3f p_component = p_m.cast<float>();
    for (int axis = 0; axis < 3; ++axis) append(out, p_component[axis]);
    if (ply) {
      for (std::uint8_t channel : item.colour) append(out, channel);
    } else {
      append(out, static_cast<std::uint32_t>(red << 16 | green << 8 | blue));
    }
  }
  return out;
}

std::string MapExport::header() const {
  std::size_t points = 0;
  for (const Item& item : items_) points += item.points;
  if (request_.format == CloudFormat::las)
    return las_header(static_cast<std::uint32_t>(points), points > 0 ? box_m_.min() : Eigen::Vector3d(0, 0, 0),
                      points > 0 ? box_m_.max() : Eigen::Vector3d(0, 0, 0));
  const bool ply = request_.format == CloudFormat::ply;
  std::ostringstream out;
  out << (ply ? "ply\nformat binary_little_endian 1.0\n" : "# .PCD v0.7 - Point Cloud Data file format\n");
  const char* comment = ply ? "comment " : "# ";
  out << comment << "headframe: component " << request_.component << " in its own frame, metres\n";
  for (const std::string& line : legend_) out << comment << line << '\n';
  if (ply) {
    out << "element vertex " << points << '\n';
    for (const char* axis : {"x", "y", "z"}) out << "property float " << axis << '\n';
    for (const char* channel : {"red", "green", "blue"}) out << "property uchar " << channel << '\n';
    out << "end_header\n";
  } else {
    // PCL wants a packed "rgb" declared as a float; its bits are the integer 0x00RRGGBB.
    out << "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " << points
        << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << points << "\nDATA binary\n";
  }
  return out.str();
}

}  // namespace headframe
