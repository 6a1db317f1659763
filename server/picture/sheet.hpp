#pragma once
// A drawing on paper: lines, text and one picture at sizes in millimetres, written as SVG, PDF or PNG.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe::picture {

using Rgb = std::array<std::uint8_t, 3>;

/// From (x0, y0) to (x1, y1). Places are in mm from the upper left, y downwards.
struct SheetLine {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0, width_mm = 0.2;
  Rgb colour{};
};

/// A polyline; filled and closed instead when `filled`.
struct SheetPath {
  std::vector<std::array<double, 2>> points;
  double width_mm = 0.3;
  Rgb colour{};
  bool filled = false;
};

enum class Align { left, middle, right };

/// (x, y) is on the base line. UTF-8; what the output's font lacks becomes '?'.
struct SheetText {
  double x = 0, y = 0, size_mm = 3;
  std::string text;
  Align align = Align::left;
  Rgb colour{};
  bool bold = false;
};

/// Pixels, row by row from the top, laid on the paper from (x, y) on; drawn before everything else.
struct SheetPicture {
  double x = 0, y = 0, width_mm = 0, height_mm = 0;
  int columns = 0, rows = 0;
  std::vector<std::uint8_t> rgb;
};

struct Sheet {
  double width_mm = 297, height_mm = 210;
  std::string title;  // of the document
  SheetPicture picture;
  std::vector<SheetPath> paths;
  std::vector<SheetLine> lines;
  std::vector<SheetText> texts;
};

/// One page, at its true size.
Result<std::string> sheet_svg(const Sheet& sheet);
Result<std::string> sheet_pdf(const Sheet& sheet);
/// So many pixels for a millimetre, as far as a canvas reaches.
Result<std::string> sheet_png(const Sheet& sheet, double px_per_mm);

}  // namespace headframe::picture
