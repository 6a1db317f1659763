#pragma once
// Which paper and which scale a plan gets, and what stands around its map. Pure.

#include <Eigen/Geometry>
#include <vector>

#include "common/result.hpp"
#include "server/picture/sheet.hpp"

namespace headframe {

struct PlanPaper {
  std::string name;  // A3
  double width_mm = 420, height_mm = 297;
  int scale = 500;  // 1:scale
  /// The map on the paper, and the place in metres of its lower left corner.
  double map_x_mm = 0, map_y_mm = 0, map_width_mm = 0, map_height_mm = 0;
  Eigen::Vector2d low_m = Eigen::Vector2d::Zero();

  /// On the paper.
  std::array<double, 2> at(const Eigen::Vector2d& p_m) const {
    const Eigen::Vector2d mm = (p_m - low_m) * 1000 / scale;
    return {map_x_mm + mm.x(), map_y_mm + map_height_mm - mm.y()};
  }
};

/// With a scale (not 0) the smallest paper from A4 to A0 that holds the box; without one A3 at the largest usual scale
/// that does. invalid_argument: it does not fit, with the scale that would.
Result<PlanPaper> plan_paper(const Eigen::AlignedBox2d& box_m, int scale);

struct PlanLegend {
  std::string name;
  picture::Rgb colour{};
};

struct PlanWords {
  std::string title, frame, shown, made;
  bool north = false;  // y is the grid's north
  std::vector<PlanLegend> legend;
};

/// Colours on white, told apart by the colour blind too; they repeat.
picture::Rgb plan_colour(std::size_t session);

/// Border, coordinates, north, scale bar and title block; the picture and what is drawn in the map are the caller's.
picture::Sheet plan_sheet(const PlanPaper& paper, const PlanWords& words);

}  // namespace headframe
