#include <array>

#include "tests/bench/descriptors/chart.hpp"
#include "tests/bench/descriptors/figures.hpp"

namespace headframe::bench {
namespace {

constexpr std::size_t most_neighbours = 20;

/// Rows that are drawn.
constexpr std::array<std::pair<const char*, const char*>, 5> drawn_rows{
    {{"same", "own mines, os1-32 in os1-32"},
     {"cross", "own mines, vlp16-hires in os1-32"},
     {"tunnel_two", "tunnel-two, vlp16-hires in os1-32"},
     {"tunnel_four", "tunnel-four, os1-32"},
     {"nclt", "nclt-two-robots, hdl-32e, outdoors"}}};

std::vector<Eigen::Vector2d> recall_over_n(const Answers& answers) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t n = 1; n <= most_neighbours; ++n) points.emplace_back(static_cast<double>(n), recall(answers, n));
  return points;
}

std::vector<Eigen::Vector2d> precision_over_recall(const Answers& answers) {
  std::vector<Eigen::Vector2d> points;
  for (const TradeOff& point : trade_off(answers)) points.emplace_back(point.recall, point.precision);
  return points;
}

template <class Curve>
std::vector<ChartPanel> panels_of(const std::vector<FamilyFigures>& families, Curve&& curve) {
  std::vector<ChartPanel> panels;
  for (const auto& [row, title] : drawn_rows) {
    ChartPanel panel{title, {}};
    for (const FamilyFigures& f : families)
      if (const Answers* answers = f.row(row)) panel.lines.push_back({f.name, curve(*answers)});
    if (!panel.lines.empty()) panels.push_back(std::move(panel));
  }
  return panels;
}

std::vector<Eigen::Vector2d> recall_over_shift(const std::vector<Answers>& by_shift) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(by_shift.size());
  for (const Answers& answers : by_shift)
    points.emplace_back(shift_step_deg * static_cast<double>(points.size()), recall(answers, 1));
  return points;
}

std::vector<ChartPanel> shift_panels(const std::vector<FamilyFigures>& families) {
  std::vector<ChartPanel> panels;
  for (const auto& [row, title] : drawn_rows) {
    ChartPanel panel{title, {}};
    for (const FamilyFigures& f : families)
      if (const auto shifts = f.by_shift.find(row); shifts != f.by_shift.end())
        panel.lines.push_back({f.name, recall_over_shift(shifts->second)});
    if (!panel.lines.empty()) panels.push_back(std::move(panel));
  }
  return panels;
}

Chart chart_of(const std::string& title, const std::string& subtitle, const ChartAxis& x, const ChartAxis& y) {
  Chart chart;
  chart.title = title;
  chart.subtitle = subtitle;
  chart.x = x;
  chart.y = y;
  return chart;
}

}  // namespace

Result<void> draw_pictures(const std::vector<FamilyFigures>& families, const std::filesystem::path& folder) {
  const ChartAxis neighbours{"N", 0, most_neighbours, 5}, recall_axis{"recall"}, precision_axis{"precision"};
  const ChartAxis shift{"yaw shift, deg", 0, shift_last_deg, 2 * shift_step_deg};
  Chart over_n =
      chart_of("Recall over N", "Queries with a right keyframe (within 5 m, 30 % of the surface) in the first N",
               neighbours, recall_axis);
  over_n.panels = panels_of(families, recall_over_n);
  Chart over_shift = chart_of("Recall@1 over yaw shift", "The query's scan turned", shift, recall_axis);
  over_shift.panels = shift_panels(families);
  Chart over_recall = chart_of("Precision over recall",
                               "First neighbours taken up to a growing distance; places that are new count, too",
                               recall_axis, precision_axis);
  over_recall.panels = panels_of(families, precision_over_recall);
  if (auto written = write_png(over_n, folder / "recall_over_n.png"); !written) return written;
  if (auto written = write_png(over_shift, folder / "recall_over_yaw_shift.png"); !written) return written;
  return write_png(over_recall, folder / "precision_over_recall.png");
}

}  // namespace headframe::bench
