#include "server/picture/top_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace headframe::picture {

const Colour ground(0.055F, 0.067F, 0.086F), paper(0.085F, 0.100F, 0.125F), ink(0.93F, 0.94F, 0.95F),
    faint(0.55F, 0.59F, 0.65F);

namespace {

constexpr int margin = margin_px, header = 92, footer = footer_px, gap = 20, panel_header = 44;

struct Box {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = Eigen::Vector2d::Constant(-1e9);
  void add(const Eigen::Vector2d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  Eigen::Vector2d size() const { return low.x() > high.x() ? Eigen::Vector2d(1, 1) : Eigen::Vector2d(high - low); }
  Eigen::Vector2d middle() const {
    return low.x() > high.x() ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(0.5 * (low + high));
  }
};

/// Around nearly all points: a few stray returns do not shrink the map.
Box bounds(const Panel& panel) {
  std::array<std::vector<double>, 2> values;
  Box box;
  for (const Layer& layer : panel.layers) {
    for (const auto& p : layer.points) {
      const Eigen::Vector3d q = layer.T_view_cloud * p.cast<double>();
      values[0].push_back(q.x());
      values[1].push_back(q.y());
    }
    for (const auto& p : layer.trajectory) box.add((layer.T_view_cloud * p).head<2>());
  }
  if (values[0].empty()) return box;
  for (const double share : {0.002, 0.998}) {
    Eigen::Vector2d corner;
    for (int axis = 0; axis < 2; ++axis) {
      auto& v = values[static_cast<std::size_t>(axis)];
      const auto nth = v.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(v.size() - 1));
      std::nth_element(v.begin(), nth, v.end());
      corner[axis] = *nth;
    }
    box.add(corner);
  }
  return box;
}

/// From metres of a panel to pixels of the picture.
struct Frame {
  Eigen::Vector2d middle_m, middle_px;
  double px_per_m;
  int x, y, width, height;
  Eigen::Vector2f px(const Eigen::Vector3d& p) const {
    const Eigen::Vector2d d = px_per_m * (p.head<2>() - middle_m);
    return (middle_px + Eigen::Vector2d(d.x(), -d.y())).cast<float>();
  }
};

/// Rock seen from above: the more points in a pixel, the brighter; walls stand out from floors.
void draw_points(Canvas& canvas, const Layer& layer, const Frame& frame) {
  std::vector<float> count(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height), 0.0F);
  for (const auto& p : layer.points) {
    const Eigen::Vector2f at = frame.px(layer.T_view_cloud * p.cast<double>());
    const int x = static_cast<int>(std::floor(at.x())) - frame.x, y = static_cast<int>(std::floor(at.y())) - frame.y;
    if (x < 0 || y < 0 || x >= frame.width || y >= frame.height) continue;
    count[static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(x)] += 1;
  }
  const float full = full_count(count);
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const float c =
          count[static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(x)];
      if (c > 0) canvas.blend(frame.x + x, frame.y + y, layer.colour, brightness(c, full));
    }
}

void draw_trajectory(Canvas& canvas, const Layer& layer, const Frame& frame) {
  if (layer.trajectory.empty()) return;
  const Colour bright = layer.colour + 0.55F * (Colour::Ones() - layer.colour);
  for (const auto& [thickness, colour] : {std::pair{6.0F, ground}, std::pair{2.5F, bright}})
    for (std::size_t i = 0; i + 1 < layer.trajectory.size(); ++i)
      canvas.line(frame.px(layer.T_view_cloud * layer.trajectory[i]),
                  frame.px(layer.T_view_cloud * layer.trajectory[i + 1]), thickness, colour);
  const Eigen::Vector2f start = frame.px(layer.T_view_cloud * layer.trajectory.front());
  canvas.disc(start, 9, ground);
  canvas.disc(start, 7, bright);
  canvas.disc(start, 4, layer.colour);
}

void draw_panel(Canvas& canvas, const Panel& panel, const Frame& frame) {
  canvas.fill(frame.x, frame.y - panel_header, frame.width, frame.height + panel_header, paper);
  for (const Layer& layer : panel.layers) draw_points(canvas, layer, frame);
  for (const Layer& layer : panel.layers) draw_trajectory(canvas, layer, frame);
  canvas.text(frame.x + 16, frame.y - panel_header + 14, panel.title, 2, ink);
}

}  // namespace

float full_count(const std::vector<float>& counts) {
  std::vector<float> seen;
  std::copy_if(counts.begin(), counts.end(), std::back_inserter(seen), [](float c) { return c > 0; });
  if (seen.empty()) return 1;
  const auto bright = seen.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(seen.size() - 1));
  std::nth_element(seen.begin(), bright, seen.end());
  return std::max(*bright, 2.0F);
}

float brightness(float count, float full) {
  return count > 0 ? 0.18F + 0.62F * std::min(1.0F, std::log1p(count) / std::log1p(full)) : 0.0F;
}

void draw_scale_bar(Canvas& canvas, double px_per_m) {
  double length_m = 1;
  for (const double candidate : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0})
    if (candidate * px_per_m < 220) length_m = candidate;
  const auto length_px = static_cast<float>(length_m * px_per_m);
  const std::string text = std::to_string(std::lround(length_m)) + " m";
  const auto right = static_cast<float>(canvas.width() - margin),
             y = static_cast<float>(canvas.height()) - 0.5F * footer + 8;
  canvas.line({right - length_px, y}, {right, y}, 3, ink);
  for (const float x : {right - length_px, right}) canvas.line({x, y - 7}, {x, y + 7}, 3, ink);
  canvas.text(static_cast<int>(right - 0.5F * length_px) - Canvas::text_width(text, 2) / 2, static_cast<int>(y) - 26,
              text, 2, ink);
}

void draw_legend(Canvas& canvas, const std::vector<LegendEntry>& legend) {
  int x = margin;
  const int y = canvas.height() - footer / 2 - 9;
  for (const LegendEntry& entry : legend) {
    canvas.fill(x, y - 1, 18, 18, entry.colour);
    canvas.text(x + 28, y + 1, entry.text, 2, ink);
    x += 28 + Canvas::text_width(entry.text, 2) + 36;
  }
}

Colour colour_of(std::size_t index) {
  static const std::array<Colour, 6> colours{Colour(0.98F, 0.62F, 0.10F), Colour(0.25F, 0.65F, 1.00F),
                                             Colour(0.30F, 0.86F, 0.52F), Colour(0.95F, 0.42F, 0.72F),
                                             Colour(0.95F, 0.90F, 0.35F), Colour(0.65F, 0.55F, 1.00F)};
  return colours[index % colours.size()];
}

Canvas draw(const TopView& view) {
  const int count = std::max<int>(1, static_cast<int>(view.panels.size()));
  const int panel_width = (view.width_px - 2 * margin - (count - 1) * gap) / count;
  std::vector<Box> boxes;
  Eigen::Vector2d extent(1, 1);
  for (const Panel& panel : view.panels) {
    boxes.push_back(bounds(panel));
    extent = extent.cwiseMax(boxes.back().size());
  }
  const double limit_px = 1.2 * view.width_px - header - footer - panel_header;
  const double px_per_m = std::min((panel_width - 48) / extent.x(), (limit_px - 48) / extent.y());
  const int panel_height = std::max(200, static_cast<int>(std::lround(px_per_m * extent.y())) + 48);
  Canvas canvas(view.width_px, header + panel_header + panel_height + footer, ground);
  canvas.text(margin, 22, view.title, 4, ink);
  canvas.text(margin, 64, view.subtitle, 2, faint);
  for (std::size_t i = 0; i < view.panels.size(); ++i) {
    const int x = margin + static_cast<int>(i) * (panel_width + gap), y = header + panel_header;
    const Frame frame{boxes[i].middle(), {x + 0.5 * panel_width, y + 0.5 * panel_height}, px_per_m, x, y, panel_width,
                      panel_height};
    draw_panel(canvas, view.panels[i], frame);
  }
  draw_legend(canvas, view.legend);
  draw_scale_bar(canvas, px_per_m);
  return canvas;
}

Result<void> write_png(const TopView& view, const std::filesystem::path& path) { return draw(view).write_png(path); }

}  // namespace headframe::picture
