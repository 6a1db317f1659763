#include "server/picture/canvas.hpp"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <system_error>

#include "server/picture/font.hpp"

namespace headframe::picture {
namespace {

float distance(const Eigen::Vector2f& p, const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  const Eigen::Vector2f along = b - a;
  const float t = std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-9F), 0.0F, 1.0F);
  return (p - a - t * along).norm();
}

}  // namespace

Canvas::Canvas(int width, int height, const Colour& background)
    : width_(std::clamp(width, 1, 16384)),
      height_(std::clamp(height, 1, 16384)),
      pixels_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), background) {}

void Canvas::blend(int x, int y, const Colour& colour, float alpha) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  Colour& pixel = pixels_[index(x, y)];
  pixel += std::clamp(alpha, 0.0F, 1.0F) * (colour - pixel);
}

void Canvas::fill(int x, int y, int width, int height, const Colour& colour, float alpha) {
  for (int row = y; row < y + height; ++row)
    for (int column = x; column < x + width; ++column) blend(column, row, colour, alpha);
}

void Canvas::disc(const Eigen::Vector2f& centre, float radius, const Colour& colour, float alpha) {
  line(centre, centre, 2 * radius, colour, alpha);
}

void Canvas::line(const Eigen::Vector2f& a, const Eigen::Vector2f& b, float thickness, const Colour& colour,
                  float alpha) {
  if (!a.allFinite() || !b.allFinite()) return;
  const float reach = 0.5F * thickness + 1;
  const Eigen::Vector2f size(static_cast<float>(width_), static_cast<float>(height_));
  const Eigen::Vector2f low = (a.cwiseMin(b).array() - reach).max(0.0F),
                        high = (a.cwiseMax(b).array() + reach).min(size.array());
  for (int y = static_cast<int>(low.y()); y < static_cast<int>(high.y()); ++y)
    for (int x = static_cast<int>(low.x()); x < static_cast<int>(high.x()); ++x) {
      const Eigen::Vector2f p(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
      const float cover = 0.5F * thickness + 0.5F - distance(p, a, b);
      if (cover > 0) blend(x, y, colour, alpha * std::min(cover, 1.0F));
    }
}

void Canvas::text(int x, int y, std::string_view text, int scale, const Colour& colour) {
  for (const char character : text) {
    for (int row = 0; row < glyph_height; ++row)
      for (int column = 0; column < glyph_width; ++column)
        if (glyph_pixel(character, column, row)) fill(x + column * scale, y + row * scale, scale, scale, colour);
    x += glyph_pitch * scale;
  }
}

int Canvas::text_width(std::string_view text, int scale) { return static_cast<int>(text.size()) * glyph_pitch * scale; }

Result<std::string> Canvas::png() const {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * pixels_.size());
  for (const Colour& pixel : pixels_)
    for (const float value : {pixel[0], pixel[1], pixel[2]})
      bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(value, 0.0F, 1.0F))));
  return png_of(width_, height_, bytes);
}

Result<std::string> png_of(int columns, int rows, const std::vector<std::uint8_t>& rgb) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(columns);
  image.height = static_cast<png_uint_32>(rows);
  image.format = PNG_FORMAT_RGB;
  std::string out(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');
  png_alloc_size_t size = out.size();
  if (png_image_write_to_memory(&image, out.data(), &size, 0, rgb.data(), 0, nullptr) == 0)
    return failure(ErrorCode::internal, std::string("cannot make the picture: ") + image.message);
  out.resize(size);
  return out;
}

Result<void> Canvas::write_png(const std::filesystem::path& path) const {
  const auto bytes = png();
  if (!bytes) return tl::unexpected(bytes.error());
  std::ofstream file(path, std::ios::binary);
  file << *bytes << std::flush;
  if (file) return {};
  return failure(ErrorCode::unavailable,
                 "cannot write the picture " + path.string() + ": " + std::generic_category().message(errno));
}

}  // namespace headframe::picture
