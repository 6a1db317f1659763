#include "server/operator/plan_layout.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace headframe {
namespace {

using picture::Align;
using picture::Rgb;
using picture::Sheet;

constexpr double left_mm = 22, right_mm = 10, top_mm = 10, bottom_mm = 46;  // includes the title block of block_mm
constexpr double block_mm = 28, edge_mm = 10;
constexpr double lines_every_mm = 40, bar_most_mm = 50;
constexpr std::array usual_scales{50, 100, 200, 250, 500, 1000, 2000, 2500, 5000, 10000, 20000, 50000, 100000};
constexpr std::array<const char*, 5> paper_names{"A4", "A3", "A2", "A1", "A0"};
constexpr std::array<std::array<double, 2>, 5> papers_mm{{{210, 297}, {297, 420}, {420, 594}, {594, 841}, {841, 1189}}};
constexpr Rgb ink{20, 24, 28}, faint{110, 118, 126}, line{205, 210, 214};

bool fits(const Eigen::Vector2d& size_m, int scale, double width_mm, double height_mm) {
  const Eigen::Vector2d size_mm = size_m * 1000 / scale;
  return size_mm.x() <= width_mm - left_mm - right_mm && size_mm.y() <= height_mm - top_mm - bottom_mm;
}

PlanPaper laid_out(const Eigen::AlignedBox2d& box_m, std::size_t paper, bool upright, int scale) {
  PlanPaper out{paper_names.at(paper),
                papers_mm.at(paper)[upright ? 0 : 1],
                papers_mm.at(paper)[upright ? 1 : 0],
                scale,
                left_mm,
                top_mm,
                0,
                0,
                {}};
  out.map_width_mm = out.width_mm - left_mm - right_mm;
  out.map_height_mm = out.height_mm - top_mm - bottom_mm;
  out.low_m = box_m.center() - 0.5 * Eigen::Vector2d(out.map_width_mm, out.map_height_mm) * scale / 1000;
  return out;
}

/// The smallest number that is at least `least` and 1, 2 or 5 times a power of ten, but at least 0.1.
double round_step(double least) {
  double step = 0.1;
  for (int i = 0; step < least; ++i) step *= i % 3 == 1 ? 2.5 : 2;
  return step;
}

void add_grid(Sheet& sheet, const PlanPaper& paper) {
  const double step_m = round_step(lines_every_mm * paper.scale / 1000);
  const auto named = [](double value) { return std::to_string(std::llround(value)); };
  for (int axis = 0; axis < 2; ++axis) {
    const double low_m = paper.low_m[axis],
                 high_m = low_m + (axis == 0 ? paper.map_width_mm : paper.map_height_mm) * paper.scale / 1000;
    const auto last = static_cast<std::int64_t>(std::floor(high_m / step_m));
    for (auto at = static_cast<std::int64_t>(std::ceil(low_m / step_m)); at <= last; ++at) {
      const double value = static_cast<double>(at) * step_m;
      Eigen::Vector2d p = paper.low_m;
      p[axis] = value;
      const auto [x, y] = paper.at(p);
      if (axis == 0) {
        sheet.lines.push_back({x, paper.map_y_mm, x, paper.map_y_mm + paper.map_height_mm, 0.1, line});
        sheet.texts.push_back(
            {x, paper.map_y_mm + paper.map_height_mm + 4, 2.4, named(value), Align::middle, faint, false});
      } else {
        sheet.lines.push_back({paper.map_x_mm, y, paper.map_x_mm + paper.map_width_mm, y, 0.1, line});
        sheet.texts.push_back({paper.map_x_mm - 1.5, y + 0.8, 2.4, named(value), Align::right, faint, false});
      }
    }
  }
}

void add_border(Sheet& sheet, double x, double y, double width, double height) {
  sheet.lines.push_back({x, y, x + width, y, 0.3, ink});
  sheet.lines.push_back({x, y + height, x + width, y + height, 0.3, ink});
  sheet.lines.push_back({x, y, x, y + height, 0.3, ink});
  sheet.lines.push_back({x + width, y, x + width, y + height, 0.3, ink});
}

void add_north(Sheet& sheet, const PlanPaper& paper, bool north) {
  const double x = paper.map_x_mm + paper.map_width_mm - 10, y = paper.map_y_mm + 9;
  sheet.paths.push_back({{{x, y}, {x + 2.6, y + 10}, {x, y + 8.2}, {x - 2.6, y + 10}}, 0, ink, true});
  sheet.texts.push_back({x, y - 1.5, 4, north ? "N" : "y", Align::middle, ink, true});
}

void add_scale_bar(Sheet& sheet, const PlanPaper& paper, double right, double y) {
  const double most_m = bar_most_mm * paper.scale / 1000;
  double length_m = round_step(most_m);
  if (length_m > most_m * 1.001) length_m = round_step(most_m / 2.6);
  const double length_mm = length_m * 1000 / paper.scale, x = right - length_mm;
  for (int part = 0; part < 2; ++part)
    sheet.paths.push_back({{{x + part * length_mm / 2, y},
                            {x + (part + 1) * length_mm / 2, y},
                            {x + (part + 1) * length_mm / 2, y + 1.4},
                            {x + part * length_mm / 2, y + 1.4}},
                           0,
                           part == 0 ? ink : faint,
                           true});
  sheet.texts.push_back({x, y - 1, 2.4, "0", Align::middle, ink, false});
  const bool whole = length_m == std::floor(length_m);
  sheet.texts.push_back(
      {right, y - 1, 2.4,
       (whole ? std::to_string(std::llround(length_m)) : std::to_string(length_m).substr(0, 4)) + " m", Align::right,
       ink, false});
}

void add_legend(Sheet& sheet, const std::vector<PlanLegend>& legend, double x, double y, double right) {
  constexpr std::size_t rows = 4;
  constexpr double column_mm = 52, row_mm = 5.4;
  const auto room = rows * std::max<std::size_t>(1, static_cast<std::size_t>(std::max(0.0, right - x) / column_mm));
  for (std::size_t i = 0; i < std::min(legend.size(), room); ++i) {
    const auto column = static_cast<double>(std::size_t{i / rows});
    const double left = x + column_mm * column, at = y + row_mm * static_cast<double>(i % rows);
    const bool rest = i + 1 == room && legend.size() > room;
    if (!rest)
      sheet.paths.push_back(
          {{{left, at - 2.2}, {left + 3, at - 2.2}, {left + 3, at}, {left, at}}, 0, legend[i].colour, true});
    sheet.texts.push_back({left + 5, at, 2.8, rest ? std::to_string(legend.size() - i) + " more" : legend[i].name,
                           Align::left, ink, false});
  }
}

}  // namespace

Result<PlanPaper> plan_paper(const Eigen::AlignedBox2d& box_m, int scale) {
  const Eigen::Vector2d size_m = box_m.sizes();
  constexpr std::size_t a3 = 1, a0 = papers_mm.size() - 1;
  const auto on = [&](std::size_t paper, int at) -> std::optional<PlanPaper> {
    const auto [narrow, wide] = papers_mm.at(paper);
    if (fits(size_m, at, wide, narrow)) return laid_out(box_m, paper, false, at);
    if (fits(size_m, at, narrow, wide)) return laid_out(box_m, paper, true, at);
    return std::nullopt;
  };
  for (std::size_t paper = 0; scale > 0 && paper <= a0; ++paper)
    if (auto found = on(paper, scale)) return *found;
  for (const int usual : usual_scales) {
    auto found = on(scale > 0 ? a0 : a3, usual);
    if (!found) continue;
    if (scale == 0) return *found;
    return failure(
        ErrorCode::invalid_argument,
        "at 1:" + std::to_string(scale) + " the plan is larger than A0; give a scale of " + std::to_string(usual));
  }
  return failure(ErrorCode::invalid_argument, "the map is " + std::to_string(std::llround(size_m.maxCoeff() / 1000)) +
                                                  " km wide: no plan of it fits A0 at 1:100000");
}

Rgb plan_colour(std::size_t session) {
  constexpr std::array<Rgb, 8> colours{{{11, 124, 184},
                                        {184, 117, 0},
                                        {0, 121, 90},
                                        {168, 72, 125},
                                        {68, 83, 196},
                                        {184, 74, 0},
                                        {79, 125, 18},
                                        {133, 117, 0}}};
  return colours.at(session % colours.size());
}

Sheet plan_sheet(const PlanPaper& paper, const PlanWords& words) {
  Sheet sheet{paper.width_mm, paper.height_mm, words.title, {}, {}, {}, {}};
  add_grid(sheet, paper);
  add_border(sheet, paper.map_x_mm, paper.map_y_mm, paper.map_width_mm, paper.map_height_mm);
  add_north(sheet, paper, words.north);
  const double top = paper.height_mm - edge_mm - block_mm, right = paper.width_mm - right_mm;
  add_border(sheet, left_mm, top, right - left_mm, block_mm);
  const double x = left_mm + 4;
  sheet.texts.push_back({x, top + 7, 4.2, words.title, Align::left, ink, true});
  sheet.texts.push_back({x, top + 13, 2.8, words.frame, Align::left, ink, false});
  sheet.texts.push_back({x, top + 18.4, 2.8, words.shown, Align::left, ink, false});
  sheet.texts.push_back({x, top + 23.8, 2.8, words.made, Align::left, faint, false});
  add_legend(sheet, words.legend, left_mm + 88, top + 7.5, right - 62);
  sheet.texts.push_back({right - 4, top + 9, 6, "1:" + std::to_string(paper.scale), Align::right, ink, true});
  sheet.texts.push_back(
      {right - 4, top + 14, 2.8, "on " + paper.name + ", printed at 100 %", Align::right, faint, false});
  add_scale_bar(sheet, paper, right - 4, top + 21.5);
  return sheet;
}

}  // namespace headframe
