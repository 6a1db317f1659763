#pragma once
// Line charts as PNG.

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe::bench {

struct ChartAxis {
  std::string label;
  double low = 0, high = 1, step = 0.2;  // numbers stand at low, low + step, ...
};

struct ChartLine {
  std::string name;
  std::vector<Eigen::Vector2d> points;
};

struct ChartPanel {
  std::string title;
  std::vector<ChartLine> lines;  // the same families in the same order in every panel
};

/// Panels on one scale, three a row; the legend names the first panel's lines.
struct Chart {
  std::string title, subtitle;
  ChartAxis x, y;
  std::vector<ChartPanel> panels;
};

/// Fails (unavailable) when the file cannot be written.
Result<void> write_png(const Chart& chart, const std::filesystem::path& path);

}  // namespace headframe::bench
