#include "tests/bench/descriptors/chart.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/picture/canvas.hpp"
#include "server/picture/top_view.hpp"

namespace headframe::bench {
namespace {

using picture::Canvas;
using picture::margin_px;

constexpr int columns = 3, panel_width = 560, panel_height = 460, header = 92;
constexpr int left = 76, right = 24, top = 76, bottom = 66;  // around the plot within its panel
constexpr int scale = 2, glyph_rows = 9 * scale;

/// The plot of one panel: from values to pixels.
struct Plot {
  const Chart& chart;
  int x, y, width, height;  // pixels

  Eigen::Vector2f px(double u, double v) const {
    const auto part = [](const ChartAxis& axis, double value) {
      return std::clamp((value - axis.low) / (axis.high - axis.low), 0.0, 1.0);
    };
    return {static_cast<float>(x + part(chart.x, u) * width), static_cast<float>(y + (1 - part(chart.y, v)) * height)};
  }
};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

void draw_axes(Canvas& canvas, const Plot& plot) {
  const Chart& chart = plot.chart;
  const auto ticks = [](const ChartAxis& axis) { return std::lround((axis.high - axis.low) / axis.step); };
  for (long i = 0; i <= ticks(chart.x); ++i) {
    const double value = chart.x.low + chart.x.step * static_cast<double>(i);
    const std::string text = number(value);
    canvas.line(plot.px(value, chart.y.low), plot.px(value, chart.y.high), 1, picture::faint, 0.35F);
    canvas.text(static_cast<int>(plot.px(value, 0).x()) - Canvas::text_width(text, scale) / 2, plot.y + plot.height + 8,
                text, scale, picture::faint);
  }
  for (long i = 0; i <= ticks(chart.y); ++i) {
    const double value = chart.y.low + chart.y.step * static_cast<double>(i);
    const std::string text = number(value);
    canvas.line(plot.px(chart.x.low, value), plot.px(chart.x.high, value), 1, picture::faint, 0.35F);
    canvas.text(plot.x - 10 - Canvas::text_width(text, scale),
                static_cast<int>(plot.px(chart.x.low, value).y()) - glyph_rows / 2 + 2, text, scale, picture::faint);
  }
  canvas.text(plot.x + (plot.width - Canvas::text_width(chart.x.label, scale)) / 2, plot.y + plot.height + 34,
              chart.x.label, scale, picture::ink);
  canvas.text(plot.x - left + 12, plot.y - 28, chart.y.label, scale, picture::ink);
}

void draw_panel(Canvas& canvas, const Chart& chart, const ChartPanel& panel, int x, int y) {
  canvas.fill(x, y, panel_width, panel_height, picture::paper);
  canvas.text(x + 12, y + 14, panel.title, scale, picture::ink);
  const Plot plot{chart, x + left, y + top, panel_width - left - right, panel_height - top - bottom};
  draw_axes(canvas, plot);
  for (std::size_t k = 0; k < panel.lines.size(); ++k) {
    const auto& points = panel.lines[k].points;
    const picture::Colour colour = picture::colour_of(k);
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      canvas.line(plot.px(points[i].x(), points[i].y()), plot.px(points[i + 1].x(), points[i + 1].y()), 2.5F, colour);
    if (points.size() <= 40)
      for (const auto& p : points) canvas.disc(plot.px(p.x(), p.y()), 4, colour);
  }
}

}  // namespace

Result<void> write_png(const Chart& chart, const std::filesystem::path& path) {
  const int count = static_cast<int>(chart.panels.size());
  const int across = std::clamp(count, 2, columns);  // room for the title
  const int down = (count + columns - 1) / columns;
  Canvas canvas(2 * margin_px + across * (panel_width + margin_px) - margin_px,
                header + down * (panel_height + margin_px) + picture::footer_px, picture::ground);
  canvas.text(margin_px, 22, chart.title, 4, picture::ink);
  canvas.text(margin_px, 64, chart.subtitle, scale, picture::faint);
  for (int i = 0; i < count; ++i)
    draw_panel(canvas, chart, chart.panels[static_cast<std::size_t>(i)],
               margin_px + i % columns * (panel_width + margin_px), header + i / columns * (panel_height + margin_px));
  std::vector<picture::LegendEntry> legend;
  if (count > 0)
    for (const ChartLine& line : chart.panels.front().lines)
      legend.push_back({line.name, picture::colour_of(legend.size())});
  picture::draw_legend(canvas, legend);
  return canvas.write_png(path);
}

}  // namespace headframe::bench
