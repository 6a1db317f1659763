#include <algorithm>
#include <cmath>

#include "server/picture/canvas.hpp"
#include "server/picture/sheet.hpp"

namespace headframe::picture {
namespace {

Colour colour_of(const Rgb& rgb) { return Colour(rgb[0], rgb[1], rgb[2]) / 255.0F; }

/// Each pixel of the canvas takes the darkest of those of the picture that it holds: thin walls stay.
void draw(Canvas& canvas, const SheetPicture& picture, double px_per_mm) {
  const double across = picture.columns / (picture.width_mm * px_per_mm),
               down = picture.rows / (picture.height_mm * px_per_mm);
  const int left = static_cast<int>(std::lround(picture.x * px_per_mm)),
            top = static_cast<int>(std::lround(picture.y * px_per_mm));
  const int width = static_cast<int>(picture.width_mm * px_per_mm),
            height = static_cast<int>(picture.height_mm * px_per_mm);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Rgb darkest{255, 255, 255};
      int least = 3 * 255;
      const int last_row =
          std::min(picture.rows, std::max(static_cast<int>((y + 1) * down), static_cast<int>(y * down) + 1));
      const int last_column =
          std::min(picture.columns, std::max(static_cast<int>((x + 1) * across), static_cast<int>(x * across) + 1));
      for (int row = static_cast<int>(y * down); row < last_row; ++row)
        for (int column = static_cast<int>(x * across); column < last_column; ++column) {
          const auto at = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.columns) +
                               static_cast<std::size_t>(column));
          const int sum = picture.rgb[at] + picture.rgb[at + 1] + picture.rgb[at + 2];
          if (sum < least) least = sum, darkest = {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
        }
      if (least < 3 * 255) canvas.blend(left + x, top + y, colour_of(darkest), 1);
    }
}

void draw(Canvas& canvas, const SheetPath& path, double px_per_mm) {
  const auto px = [&](const std::array<double, 2>& p) -> Eigen::Vector2d {
    return Eigen::Vector2d(p[0], p[1]) * px_per_mm;
  };
  if (!path.filled) {
    for (std::size_t i = 1; i < path.points.size(); ++i)
      canvas.line(px(path.points[i - 1]).cast<float>(), px(path.points[i]).cast<float>(),
                  static_cast<float>(std::max(1.0, path.width_mm * px_per_mm)), colour_of(path.colour));
    return;
  }
  // Filled shapes are small and convex or nearly so: each row from its leftmost to its rightmost crossing.
  double low = 1e9, high = -1e9;
  for (const auto& p : path.points) low = std::min(low, p[1] * px_per_mm), high = std::max(high, p[1] * px_per_mm);
  for (int y = static_cast<int>(low); y <= static_cast<int>(high); ++y) {
    double left = 1e9, right = -1e9;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const Eigen::Vector2d p = px(path.points[i]), q = px(path.points[(i + 1) % path.points.size()]);
      const double at = (y + 0.5 - p.y()) / (q.y() - p.y());
      if (!(at >= 0 && at <= 1)) continue;
      left = std::min(left, p.x() + at * (q.x() - p.x())), right = std::max(right, p.x() + at * (q.x() - p.x()));
    }
    if (right >= left)
      canvas.fill(static_cast<int>(left), y, static_cast<int>(right - left) + 1, 1, colour_of(path.colour));
  }
}

void draw(Canvas& canvas, const SheetText& text, double px_per_mm) {
  const int scale = std::max(1, static_cast<int>(std::lround(text.size_mm * px_per_mm / 9)));
  std::string ascii;
  for (const char c : text.text)
    if ((static_cast<unsigned char>(c) & 0xc0U) != 0x80) ascii += static_cast<unsigned char>(c) < 0x80 ? c : '?';
  const double share = text.align == Align::left ? 0 : text.align == Align::middle ? 0.5 : 1;
  const int x = static_cast<int>(text.x * px_per_mm - share * Canvas::text_width(ascii, scale));
  const int y = static_cast<int>(text.y * px_per_mm) - 7 * scale;
  for (int dx = 0; dx <= (text.bold ? std::max(1, scale / 2) : 0); ++dx)
    canvas.text(x + dx, y, ascii, scale, colour_of(text.colour));
}

}  // namespace

Result<std::string> sheet_png(const Sheet& sheet, double px_per_mm) {
  Canvas canvas(static_cast<int>(std::lround(sheet.width_mm * px_per_mm)),
                static_cast<int>(std::lround(sheet.height_mm * px_per_mm)), Colour::Ones());
  if (sheet.picture.columns > 0) draw(canvas, sheet.picture, px_per_mm);
  for (const SheetPath& path : sheet.paths) draw(canvas, path, px_per_mm);
  for (const SheetLine& line : sheet.lines)
    canvas.line(Eigen::Vector2d(line.x0, line.y0).cast<float>() * static_cast<float>(px_per_mm),
                Eigen::Vector2d(line.x1, line.y1).cast<float>() * static_cast<float>(px_per_mm),
                static_cast<float>(std::max(1.0, line.width_mm * px_per_mm)), colour_of(line.colour));
  for (const SheetText& text : sheet.texts) draw(canvas, text, px_per_mm);
  return canvas.png();
}

}  // namespace headframe::picture
