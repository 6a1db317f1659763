#pragma once
// A picture in memory: pixels, lines, text; written as PNG.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe::picture {

/// Red, green, blue in [0, 1].
using Colour = Eigen::Array3f;

/// x to the right, y down, in pixels from the upper left. What is drawn outside is cut off.
class Canvas {
 public:
  /// Both sizes within 1 to 16384.
  Canvas(int width, int height, const Colour& background);

  int width() const { return width_; }
  int height() const { return height_; }
  const Colour& at(int x, int y) const { return pixels_[index(x, y)]; }

  /// Mixes the colour in; alpha in [0, 1].
  void blend(int x, int y, const Colour& colour, float alpha);
  void fill(int x, int y, int width, int height, const Colour& colour, float alpha = 1);
  void disc(const Eigen::Vector2f& centre, float radius, const Colour& colour, float alpha = 1);
  void line(const Eigen::Vector2f& a, const Eigen::Vector2f& b, float thickness, const Colour& colour, float alpha = 1);
  /// (x, y) is the upper left of the first character; scale: pixels of the picture for one of the font.
  void text(int x, int y, std::string_view text, int scale, const Colour& colour);
  static int text_width(std::string_view text, int scale);

  /// The bytes of a PNG file.
  Result<std::string> png() const;
  /// Fails (unavailable) when the file cannot be written.
  Result<void> write_png(const std::filesystem::path& path) const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  std::vector<Colour> pixels_;
};

/// The bytes of a PNG file of red, green, blue, row by row from the top.
Result<std::string> png_of(int columns, int rows, const std::vector<std::uint8_t>& rgb);

}  // namespace headframe::picture
