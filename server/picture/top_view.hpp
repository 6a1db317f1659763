#pragma once
// Maps seen from above: clouds and trajectories in panels side by side, at one scale, with a legend and a scale bar.

#include <filesystem>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "server/picture/canvas.hpp"

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

/// Of the ground, of a panel on it, of what is written, and of what stands back.
extern const Colour ground, paper, ink, faint;

/// At the lower right, and in the lowest row from the left: of a canvas with footer_px for them.
constexpr int margin_px = 28, footer_px = 64;
void draw_scale_bar(Canvas& canvas, double px_per_m);
void draw_legend(Canvas& canvas, const std::vector<LegendEntry>& legend);

/// Light by how many points fell on a pixel (count, of which `full` is as bright as it gets); 0 without any.
float brightness(float count, float full);
/// What makes brightness() full: so many or more fell on one of twenty pixels that have any.
float full_count(const std::vector<float>& counts);

/// Draws it. The height follows from the maps' shape (at most 1.2 widths). Empty panels and layers are fine.
Canvas draw(const TopView& view);

/// Draws it into a PNG file; fails (unavailable) when that cannot be written.
Result<void> write_png(const TopView& view, const std::filesystem::path& path);

}  // namespace headframe::picture
