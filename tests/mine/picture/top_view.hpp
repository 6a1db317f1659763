#pragma once
// Maps seen from above: clouds and trajectories in panels side by side, at one scale, with a legend and a scale bar.

#include <filesystem>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "tests/mine/picture/canvas.hpp"

namespace headframe::picture {

/// One thing of one colour, placed in the panel by T_view_cloud. Metres; the view's x is to the right, its y up.
struct Layer {
  Points points;
  std::vector<Eigen::Vector3d> trajectory;  // in the same frame as the points; drawn as a line, a dot at its start
  Pose T_view_cloud = Pose::Identity();
  Colour colour = Colour::Ones();
};

struct Panel {
  std::string title;
  std::vector<Layer> layers;
};

struct LegendEntry {
  std::string text;
  Colour colour = Colour::Ones();
};

struct TopView {
  std::string title;
  std::string subtitle;
  std::vector<Panel> panels;
  std::vector<LegendEntry> legend;
  int width_px = 1600;
};

/// Colours that are told apart on dark ground, also by the colour blind; repeats after the last.
Colour colour_of(std::size_t index);

/// Draws it. The height follows from the maps' shape (at most 1.2 widths). Empty panels and layers are fine.
Canvas draw(const TopView& view);

/// Draws it into a PNG file; fails (unavailable) when that cannot be written.
Result<void> write_png(const TopView& view, const std::filesystem::path& path);

}  // namespace headframe::picture
