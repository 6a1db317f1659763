#include "server/operator/plan.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

#include "server/picture/top_view.hpp"

namespace headframe {
namespace {

constexpr double roof_m = 0.5;  // above the sensor
constexpr double margin_m = 1;  // minimum margin around the points
constexpr double most_px = 12e6;
constexpr double png_px_per_mm = 6;
// Stamps above wall_clock_s are seconds since 1970. Dates are printed only before year_10000_s: later ones are not real
// dates.
constexpr double wall_clock_s = 1e9, year_10000_s = 253402300800;

std::string day_of(double unix_s) {
  const auto time = static_cast<std::time_t>(unix_s);
  std::tm day{};
  ::gmtime_r(&time, &day);
  std::array<char, 16> text;
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d", &day)};
}

std::string metres(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.1f m", value);
  return text.data();
}

}  // namespace

Result<std::optional<std::string>> Plan::next() {
  switch (stage_) {
    case Stage::begin:
      stage_ = Stage::measure;
      if (auto ready = begin(); !ready) return tl::unexpected(ready.error());
      return std::string();
    case Stage::measure: {
      const auto grow = [&](const Eigen::Vector3d& p_m) { box_m_.extend(p_m.head<2>()); };
      if (auto done = each_point(placed_.keyframes[at_++], grow); !done) return tl::unexpected(done.error());
      if (at_ == placed_.keyframes.size()) stage_ = Stage::choose;
      return std::string();
    }
    case Stage::choose:
      stage_ = Stage::paint;
      at_ = 0;
      if (auto chosen = choose(); !chosen) return tl::unexpected(chosen.error());
      return std::string();
    case Stage::paint: {
      const PlacedKeyframe& keyframe = placed_.keyframes[at_++];
      const auto dab = [&](const Eigen::Vector3d& p_m) { paint(p_m, keyframe.session); };
      if (auto done = each_point(keyframe, dab); !done) return tl::unexpected(done.error());
      if (at_ == placed_.keyframes.size()) stage_ = Stage::write;
      return std::string();
    }
    case Stage::write:
      stage_ = Stage::done;
      return written().map([](std::string bytes) { return std::optional(std::move(bytes)); });
    case Stage::done: break;
  }
  return std::nullopt;
}

Result<void> Plan::begin() {
  auto placed = placed_component(station_, request_.component, request_.frame);
  if (!placed) return tl::unexpected(placed.error());
  placed_ = std::move(*placed);
  if (placed_.keyframes.empty())
    return failure(ErrorCode::not_found, "component " + std::to_string(request_.component) + " has no keyframe yet");
  for (const PlacedKeyframe& keyframe : placed_.keyframes)
    box_m_.extend(keyframe.T_frame_sensor.translation().head<2>());
  return {};
}

Result<void> Plan::choose() {
  box_m_.min().array() -= margin_m, box_m_.max().array() += margin_m;
  auto paper = plan_paper(box_m_, request_.scale);
  if (!paper) return tl::unexpected(paper.error());
  paper_ = *paper;
  mm_per_px_ = std::max(request_.pixel_mm, std::sqrt(paper_.map_width_mm * paper_.map_height_mm / most_px));
  columns_ = static_cast<int>(paper_.map_width_mm / mm_per_px_),
  rows_ = static_cast<int>(paper_.map_height_mm / mm_per_px_);
  const std::size_t pixels = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  counts_.assign(pixels, 0);
  sessions_.assign(pixels, 0);
  return {};
}

template <class Take>
Result<void> Plan::each_point(const PlacedKeyframe& keyframe, Take take) const {
  const auto cloud = station_.cloud(placed_.sessions[keyframe.session].id, keyframe.sequence);
  if (!cloud && cloud.error().code == ErrorCode::not_found) return {};
  if (!cloud) return tl::unexpected(cloud.error());
  const double roof = keyframe.T_frame_sensor.translation().z() + roof_m;
  for (const Sweep& sweep : cloud->sweeps)
    for (const Eigen::Vector3f& p_sensor : sweep.points) {
      if (!p_sensor.allFinite()) continue;
      const Eigen::Vector3d p_m = keyframe.T_frame_sensor * p_sensor.cast<double>();
      if (p_m.z() < roof && p_m.z() >= request_.low_m && p_m.z() <= request_.high_m) take(p_m);
    }
  return {};
}

void Plan::paint(const Eigen::Vector3d& p_m, std::size_t session) {
  const auto [x, y] = paper_.at(p_m.head<2>());
  const int column = static_cast<int>((x - paper_.map_x_mm) / mm_per_px_),
            row = static_cast<int>((y - paper_.map_y_mm) / mm_per_px_);
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;  // from a cloud stored after measuring
  const std::size_t pixel =
      static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  counts_[pixel] =
      static_cast<std::uint16_t>(std::min<int>(counts_[pixel] + 1, std::numeric_limits<std::uint16_t>::max()));
  sessions_[pixel] = static_cast<std::uint16_t>(session);
}

picture::SheetPicture Plan::picture() const {
  picture::SheetPicture out{
      paper_.map_x_mm, paper_.map_y_mm, columns_ * mm_per_px_, rows_ * mm_per_px_, columns_, rows_, {}};
  out.rgb.assign(3 * counts_.size(), 255);
  const float full = picture::full_count({counts_.begin(), counts_.end()});
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    if (counts_[pixel] == 0) continue;
    const float ink = std::min(1.0F, 0.25F + picture::brightness(counts_[pixel], full));
    const picture::Rgb colour = plan_colour(sessions_[pixel]);
    for (std::size_t channel = 0; channel < 3; ++channel)
      out.rgb[3 * pixel + channel] =
          static_cast<std::uint8_t>(255 - ink * static_cast<float>(255 - colour.at(channel)));
  }
  return out;
}

PlanWords Plan::words() const {
  const bool grid = request_.frame == OutputFrame::grid;
  PlanWords out;
  std::vector<double> first_s(placed_.sessions.size(), 0);
  for (auto keyframe = placed_.keyframes.rbegin(); keyframe != placed_.keyframes.rend(); ++keyframe)
    first_s[keyframe->session] = keyframe->stamp_s;
  for (std::size_t i = 0; i < placed_.sessions.size(); ++i) {
    const SessionRow& row = placed_.sessions[i];
    const bool dated = first_s[i] > wall_clock_s && first_s[i] < year_10000_s;
    const std::string when = dated ? ", " + day_of(first_s[i]) : std::string();
    out.legend.push_back({(row.label.empty() ? row.key.robot : row.label) + when, plan_colour(i)});
  }
  const std::size_t count = placed_.sessions.size();
  out.title = count == 1 ? "Plan of " + out.legend.front().name : "Plan of " + std::to_string(count) + " sessions";
  out.north = grid;
  out.frame = grid ? "mine grid: east, north in metres" : "own frame: x, y in metres";
  const bool sliced = std::isfinite(request_.low_m) || std::isfinite(request_.high_m);
  out.shown =
      "roof cut " + metres(roof_m) + " above the sensor" +
      (sliced ? "; heights " + (std::isfinite(request_.low_m) ? "from " + metres(request_.low_m) : std::string()) +
                    (std::isfinite(request_.high_m) ? " to " + metres(request_.high_m) : std::string())
              : std::string());
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  out.made =
      "made " + day_of(static_cast<double>(now)) + ", revision " + std::to_string(station_.atlas().atlas.revision);
  return out;
}

Result<std::string> Plan::written() const {
  picture::Sheet sheet = plan_sheet(paper_, words());
  sheet.picture = picture();
  for (std::size_t i = 0; i < placed_.keyframes.size(); ++i) {
    const PlacedKeyframe& keyframe = placed_.keyframes[i];
    if (i == 0 || placed_.keyframes[i - 1].session != keyframe.session)
      sheet.paths.push_back({{}, 0.25, plan_colour(keyframe.session), false});
    sheet.paths.back().points.push_back(paper_.at(keyframe.T_frame_sensor.translation().head<2>()));
  }
  switch (request_.format) {
    case PlanFormat::svg: return picture::sheet_svg(sheet);
    case PlanFormat::pdf: return picture::sheet_pdf(sheet);
    case PlanFormat::png: break;
  }
  return picture::sheet_png(sheet, std::min(png_px_per_mm, 6000 / std::max(sheet.width_mm, sheet.height_mm)));
}

}  // namespace headframe
