#include "server/operator/plan_png.hpp"

#include <algorithm>
#include <cmath>

#include "server/picture/top_view.hpp"

namespace headframe {
namespace {

using picture::Canvas;

constexpr int width_px = 1600, most_height_px = 2000, least_height_px = 300;
constexpr int left_px = 110, right_px = 28, top_px = 92, bottom_px = picture::footer_px + 40;
constexpr double around_m = 20;  // seen from the outermost keyframes
constexpr double roof_m = 0.5;   // above the sensor
constexpr double most_px_per_m = 40;
constexpr double line_every_px = 150;  // at least

/// 1, 2 or 5 times a power of ten, in whole metres, at least so much.
double round_step(double least) {
  double step = 1;
  for (int i = 0; step < least; ++i) step *= i % 3 == 1 ? 2.5 : 2;
  return step;
}

std::string name_of(const SessionRow& row) {
  return row.label.empty() ? row.key.robot + "/" + row.key.session : row.label;
}

}  // namespace

Result<std::optional<std::string>> PlanPng::next() {
  if (done_) return std::nullopt;
  if (!std::exchange(begun_, true)) {
    if (auto ready = begin(); !ready) return tl::unexpected(ready.error());
    return std::string();
  }
  if (at_ < placed_.keyframes.size()) {
    if (auto added = add(placed_.keyframes[at_++]); !added) return tl::unexpected(added.error());
    return std::string();
  }
  done_ = true;
  return picture().map([](std::string png) { return std::optional(std::move(png)); });
}

Result<void> PlanPng::begin() {
  auto placed = placed_component(station_, component_, frame_);
  if (!placed) return tl::unexpected(placed.error());
  placed_ = std::move(*placed);
  if (placed_.keyframes.empty())
    return failure(ErrorCode::not_found, "component " + std::to_string(component_) + " has no keyframe yet");
  Eigen::Vector2d low = placed_.keyframes.front().T_frame_sensor.translation().head<2>(), high = low;
  for (const PlacedKeyframe& keyframe : placed_.keyframes) {
    low = low.cwiseMin(keyframe.T_frame_sensor.translation().head<2>());
    high = high.cwiseMax(keyframe.T_frame_sensor.translation().head<2>());
  }
  const Eigen::Vector2d size_m = (high - low).array() + 2 * around_m;
  sheet_.width_px = width_px - left_px - right_px;
  sheet_.px_per_m =
      std::min({sheet_.width_px / size_m.x(), (most_height_px - top_px - bottom_px) / size_m.y(), most_px_per_m});
  sheet_.height_px = std::max(least_height_px, static_cast<int>(std::lround(size_m.y() * sheet_.px_per_m)));
  const Eigen::Vector2d shown_m(sheet_.width_px / sheet_.px_per_m, sheet_.height_px / sheet_.px_per_m);
  sheet_.low_m = 0.5 * (low + high) - 0.5 * shown_m;
  const std::size_t pixels = static_cast<std::size_t>(sheet_.width_px) * static_cast<std::size_t>(sheet_.height_px);
  counts_.assign(pixels, 0);
  colours_.assign(pixels, Eigen::Array3f::Zero());
  return {};
}

Result<void> PlanPng::add(const PlacedKeyframe& keyframe) {
  const auto cloud = station_.cloud(placed_.sessions[keyframe.session].id, keyframe.sequence);
  if (!cloud && cloud.error().code == ErrorCode::not_found) return {};
  if (!cloud) return tl::unexpected(cloud.error());
  const Eigen::Array3f colour = picture::colour_of(keyframe.session);
  const double roof = keyframe.T_frame_sensor.translation().z() + roof_m;
  for (const Sweep& sweep : cloud->sweeps)
    for (const Eigen::Vector3f& p_sensor : sweep.points) {
      if (!p_sensor.allFinite()) continue;
      const Eigen::Vector3d p = keyframe.T_frame_sensor * p_sensor.cast<double>();
      const Eigen::Vector2d at = sheet_.px(p.head<2>());
      const bool shown =
          p.z() < roof && at.x() >= 0 && at.y() >= 0 && at.x() < sheet_.width_px && at.y() < sheet_.height_px;
      if (!shown) continue;
      const std::size_t pixel = static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(sheet_.width_px) +
                                static_cast<std::size_t>(at.x());
      counts_[pixel] += 1;
      colours_[pixel] += colour;
    }
  return {};
}

namespace {

/// The frame's coordinates: faint lines across the map, named at its left and below.
void draw_grid(Canvas& canvas, const Eigen::Vector2d& low_m, double px_per_m, int map_width_px, int map_height_px) {
  const double step_m = round_step(line_every_px / px_per_m);
  const auto named = [](double value) { return std::to_string(std::llround(value)); };
  const double right_m = low_m.x() + map_width_px / px_per_m, top_m = low_m.y() + map_height_px / px_per_m;
  const int bottom = top_px + map_height_px;
  for (auto i = static_cast<std::int64_t>(std::ceil(low_m.x() / step_m)); static_cast<double>(i) * step_m <= right_m;
       ++i) {
    const double x_m = static_cast<double>(i) * step_m;
    const int x = left_px + static_cast<int>(std::lround((x_m - low_m.x()) * px_per_m));
    canvas.fill(x, top_px, 1, map_height_px, picture::faint, 0.35F);
    canvas.text(x - Canvas::text_width(named(x_m), 2) / 2, bottom + 10, named(x_m), 2, picture::faint);
  }
  for (auto i = static_cast<std::int64_t>(std::ceil(low_m.y() / step_m)); static_cast<double>(i) * step_m <= top_m;
       ++i) {
    const double y_m = static_cast<double>(i) * step_m;
    const int y = bottom - static_cast<int>(std::lround((y_m - low_m.y()) * px_per_m));
    canvas.fill(left_px, y, map_width_px, 1, picture::faint, 0.35F);
    canvas.text(left_px - 10 - Canvas::text_width(named(y_m), 2), y - 8, named(y_m), 2, picture::faint);
  }
}

void draw_north(Canvas& canvas, const char* name) {
  const auto x = static_cast<float>(canvas.width() - right_px - 24);
  const Eigen::Vector2f tip(x, 22), foot(x, 76);
  canvas.line(foot, tip, 3, picture::ink);
  canvas.line(tip, tip + Eigen::Vector2f(-8, 14), 3, picture::ink);
  canvas.line(tip, tip + Eigen::Vector2f(8, 14), 3, picture::ink);
  canvas.text(static_cast<int>(x) - 34, 22, name, 3, picture::ink);
}

}  // namespace

Result<std::string> PlanPng::picture() const {
  const bool grid = frame_ == OutputFrame::grid;
  Canvas canvas(width_px, top_px + sheet_.height_px + bottom_px, picture::ground);
  canvas.fill(left_px, top_px, sheet_.width_px, sheet_.height_px, picture::paper);
  canvas.text(left_px, 22, "Component " + std::to_string(component_), 4, picture::ink);
  canvas.text(left_px, 64,
              std::to_string(placed_.sessions.size()) + (placed_.sessions.size() == 1 ? " session, " : " sessions, ") +
                  (grid ? "mine grid" : "own frame") + ", metres; roof cut off",
              2, picture::faint);
  draw_grid(canvas, sheet_.low_m, sheet_.px_per_m, sheet_.width_px, sheet_.height_px);
  const float full = picture::full_count(counts_);
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    if (counts_[pixel] == 0) continue;
    const int x = static_cast<int>(pixel % static_cast<std::size_t>(sheet_.width_px)),
              y = static_cast<int>(pixel / static_cast<std::size_t>(sheet_.width_px));
    canvas.blend(left_px + x, top_px + y, colours_[pixel] / counts_[pixel], picture::brightness(counts_[pixel], full));
  }
  const auto on_canvas = [&](const PlacedKeyframe& keyframe) -> Eigen::Vector2f {
    return (sheet_.px(keyframe.T_frame_sensor.translation().head<2>()) + Eigen::Vector2d(left_px, top_px))
        .cast<float>();
  };
  for (std::size_t i = 1; i < placed_.keyframes.size(); ++i) {
    const PlacedKeyframe &from = placed_.keyframes[i - 1], &to = placed_.keyframes[i];
    if (from.session != to.session) continue;
    const picture::Colour colour = picture::colour_of(to.session);
    canvas.line(on_canvas(from), on_canvas(to), 2, colour + 0.55F * (picture::Colour::Ones() - colour));
  }
  draw_north(canvas, grid ? "N" : "y");
  std::vector<picture::LegendEntry> legend;
  legend.reserve(placed_.sessions.size());
  for (std::size_t i = 0; i < placed_.sessions.size(); ++i)
    legend.push_back({name_of(placed_.sessions[i]), picture::colour_of(i)});
  picture::draw_legend(canvas, legend);
  picture::draw_scale_bar(canvas, sheet_.px_per_m);
  return canvas.png();
}

}  // namespace headframe
