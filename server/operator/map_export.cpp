#include "server/operator/map_export.hpp"

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <map>
#include <sstream>

#include "server/operator/append_bytes.hpp"
#include "server/operator/las.hpp"

namespace headframe {
namespace {

constexpr double wall_clock_s = 1e9;  // greater stamps are seconds since 1970; others count from the robot's own start

constexpr std::array<std::array<std::uint8_t, 3>, 8> palette{{{230, 97, 1},
                                                              {31, 120, 180},
                                                              {51, 160, 44},
                                                              {170, 60, 200},
                                                              {227, 26, 28},
                                                              {0, 170, 170},
                                                              {200, 160, 0},
                                                              {120, 120, 120}}};

/// Names come from peers: a line break in one must not end the header's line.
std::string one_line(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '_');
  return name;
}

/// The returns of all sweeps. If only some sweeps have intensities, the others' count as 0.
Returns all_returns(const KeyframeCloud& cloud) {
  Returns out;
  out.points.reserve(point_count(cloud));
  const bool has_intensity = std::any_of(cloud.sweeps.begin(), cloud.sweeps.end(),
                                         [](const Sweep& sweep) { return !sweep.intensity.empty(); });
  for (const Sweep& sweep : cloud.sweeps)
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
      if (!sweep.points[i].allFinite()) continue;
      out.points.push_back(sweep.points[i]);
      if (has_intensity) out.intensity.push_back(sweep.intensity.empty() ? std::uint8_t{0} : sweep.intensity[i]);
    }
  return out;
}

}  // namespace

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
  auto placed = placed_component(station_, request_.component, request_.frame);
  if (!placed) return tl::unexpected(placed.error());
  origin_m_ = placed->origin_m;
  std::map<std::string, Colour> colours;
  std::vector<Colour> of_session;
  of_session.reserve(placed->sessions.size());
  for (const SessionRow& row : placed->sessions) {
    const auto [colour, first] = colours.try_emplace(row.key.robot, palette[colours.size() % palette.size()]);
    of_session.push_back(colour->second);
    if (!first) continue;
    std::ostringstream line;
    line << "robot " << one_line(row.key.robot) << " colour";
    for (int channel : colour->second) line << ' ' << channel;
    legend_.push_back(line.str());
  }
  for (const PlacedKeyframe& keyframe : placed->keyframes)
    items_.push_back({placed->sessions[keyframe.session].id, keyframe.sequence, keyframe.T_frame_sensor,
                      of_session[keyframe.session], 0, static_cast<std::uint16_t>(keyframe.session + 1),
                      keyframe.stamp_s});
  has_wall_clock_ =
      std::all_of(items_.begin(), items_.end(), [](const Item& item) { return item.stamp_s > wall_clock_s; });
  return {};
}

Result<void> MapExport::count(Item& item) {
  const auto points = thinned(item);
  if (points) {
    item.points = points->points.size();
    has_intensity_ = has_intensity_ || !points->intensity.empty();
    if (request_.format == CloudFormat::las)
      for (const Eigen::Vector3f& p_sensor : points->points)
        box_m_.extend(las_place(item.T_frame_sensor * p_sensor.cast<double>(), origin_m_));
  } else if (points.error().code != ErrorCode::not_found) {  // a keyframe without a stored cloud is left out
    return tl::unexpected(points.error());
  }
  return {};
}

Result<Returns> MapExport::thinned(const Item& item) const {
  const auto cloud = station_.cloud(item.session, item.sequence);
  if (!cloud) return tl::unexpected(cloud.error());
  Returns all = all_returns(*cloud);
  if (request_.voxel_m <= 0) return all;
  return voxel_grid(all.points, all.intensity, static_cast<float>(request_.voxel_m));
}

Result<std::string> MapExport::written(const Item& item) const {
  const auto cloud = thinned(item);
  if (!cloud) return tl::unexpected(cloud.error());
  const auto& [points, intensity] = *cloud;
  if (points.size() != item.points)
    return failure(ErrorCode::internal, "the cloud of keyframe " + std::to_string(item.sequence) + " of session " +
                                            std::to_string(item.session) + " changed during the export; start again");
  std::string out;
  out.reserve(points.size() * point_bytes());
  for (std::size_t i = 0; i < points.size(); ++i)
    append_point(out, item.T_frame_sensor * points[i].cast<double>(),
                 intensity.empty() ? std::uint8_t{0} : intensity[i], item);
  return out;
}

void MapExport::append_point(std::string& out, const Eigen::Vector3d& p_frame, std::uint8_t intensity,
                             const Item& item) const {
  if (request_.format == CloudFormat::las)
    return append_las_point(
        out,
        {p_frame, item.colour, item.source, has_wall_clock_ ? adjusted_gps_s(item.stamp_s) : item.stamp_s, intensity},
        origin_m_);
  if (wide()) {
    for (int axis = 0; axis < 3; ++axis) append_bytes(out, p_frame[axis]);
  } else {
    const Eigen::Vector3f p = (p_frame - origin_m_).cast<float>();
    for (int axis = 0; axis < 3; ++axis) append_bytes(out, p[axis]);
  }
  const auto [red, green, blue] = item.colour;
  if (request_.format == CloudFormat::pcd) {
    append_bytes(out, static_cast<std::uint32_t>(red << 16 | green << 8 | blue));
    if (has_intensity_) append_bytes(out, static_cast<float>(intensity));
    return;
  }
  for (const std::uint8_t channel : item.colour) append_bytes(out, channel);
  if (has_intensity_) append_bytes(out, intensity);
}

/// Whether coordinates are doubles: in PLY if they are far from zero. The other formats use an offset.
bool MapExport::wide() const {
  return request_.format == CloudFormat::ply && (request_.frame == OutputFrame::grid || !origin_m_.isZero());
}

std::size_t MapExport::point_bytes() const {
  if (request_.format == CloudFormat::las) return las_point_bytes;
  const std::size_t intensities = has_intensity_ ? 1 : 0;
  if (request_.format == CloudFormat::pcd)
    return 3 * sizeof(float) + sizeof(std::uint32_t) + intensities * sizeof(float);
  return 3 * (wide() ? sizeof(double) : sizeof(float)) + 3 + intensities;
}

std::string MapExport::header() {
  std::size_t points = 0;
  for (const Item& item : items_) points += item.points;
  std::string out = request_.format == CloudFormat::las ? las(points) : text_header(points);
  total_bytes_ = out.size() + points * point_bytes();
  return out;
}

std::string MapExport::las(std::size_t points) const {
  const Eigen::Vector3d nothing = origin_m_;
  const auto now_s = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return las_header({static_cast<std::uint32_t>(points), points > 0 ? box_m_.min() : nothing,
                     points > 0 ? box_m_.max() : nothing, origin_m_, static_cast<std::uint16_t>(request_.component),
                     now_s, has_wall_clock_});
}

std::string MapExport::text_header(std::size_t points) const {
  const bool ply = request_.format == CloudFormat::ply, grid = request_.frame == OutputFrame::grid;
  std::ostringstream out;
  out << (ply ? "ply\nformat binary_little_endian 1.0\n" : "# .PCD v0.7 - Point Cloud Data file format\n");
  const char* comment = ply ? "comment " : "# ";
  out << comment << "headframe: component " << request_.component << " in "
      << (grid ? "the mine's grid" : "its own frame") << ", metres\n";
  if ((grid || !origin_m_.isZero()) && !ply) {
    out << std::fixed << std::setprecision(0) << "# offset " << origin_m_.x() << ' ' << origin_m_.y() << ' '
        << origin_m_.z() << ": add it to every point\n";
  }
  for (const std::string& line : legend_) out << comment << line << '\n';
  if (ply) {
    out << "element vertex " << points << '\n';
    for (const char* axis : {"x", "y", "z"}) out << "property " << (wide() ? "double " : "float ") << axis << '\n';
    for (const char* channel : {"red", "green", "blue"}) out << "property uchar " << channel << '\n';
    if (has_intensity_) out << "property uchar intensity\n";
    out << "end_header\n";
  } else {
    // PCL requires a packed "rgb" to be declared as float; its bits are the integer 0x00RRGGBB.
    out << (has_intensity_
                ? "VERSION 0.7\nFIELDS x y z rgb intensity\nSIZE 4 4 4 4 4\nTYPE F F F F F\nCOUNT 1 1 1 1 1\nWIDTH "
                : "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH ")
        << points << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << points << "\nDATA binary\n";
  }
  return out.str();
}

}  // namespace headframe
