#pragma once
// Chooses the paper and scale of a plan, and lays out what surrounds the map. All functions are pure.

#include <Eigen/Geometry>
#include <vector>

#include "common/result.hpp"
#include "server/picture/sheet.hpp"

namespace headframe {

struct PlanPaper {
  std::string name;  // such as A3
  double width_mm = 420, height_mm = 297;
  int scale = 500;  // 1:scale
  /// The area of the map on the paper; low_m is the position in the frame (m) of its lower left corner.
  double map_x_mm = 0, map_y_mm = 0, map_width_mm = 0, map_height_mm = 0;
  Eigen::Vector2d low_m = Eigen::Vector2d::Zero();

  /// The position on the paper, in mm from its upper left corner.
  std::array<double, 2> at(const Eigen::Vector2d& p_m) const {
    const Eigen::Vector2d mm = (p_m - low_m) * 1000 / scale;
    return {map_x_mm + mm.x(), map_y_mm + map_height_mm - mm.y()};
  }
};

/// With a scale other than 0: the smallest paper from A4 to A0 that holds the box. With scale 0: A3 at the largest
/// usual scale that holds it. invalid_argument: it does not fit; the message names the scale that would.
Result<PlanPaper> plan_paper(const Eigen::AlignedBox2d& box_m, int scale);

struct PlanLegend {
  std::string name;
  picture::Rgb colour{};
};

struct PlanWords {
  std::string title, frame, shown, made;
  bool north = false;  // y points to the grid's north
  std::vector<PlanLegend> legend;
};

/// Colours on white that colour-blind people can distinguish too. They repeat after eight sessions.
picture::Rgb plan_colour(std::size_t session);

/// Draws border, coordinates, north arrow, scale bar and title block. The caller adds the picture and everything within
/// the map.
picture::Sheet plan_sheet(const PlanPaper& paper, const PlanWords& words);

}  // namespace headframe
