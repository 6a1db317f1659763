#include <gtest/gtest.h>
#include <png.h>

#include <set>

#include "server/picture/font.hpp"
#include "server/picture/top_view.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe::picture {
namespace {

TEST(Font, PrintableCharactersAllLookDifferent) {
  std::set<std::vector<bool>> shapes;
  for (char c = ' '; c <= '~'; ++c) {
    std::vector<bool> shape;
    for (int row = 0; row < glyph_height; ++row)
      for (int column = 0; column < glyph_width; ++column) shape.push_back(glyph_pixel(c, column, row));
    EXPECT_TRUE(shapes.insert(shape).second) << c;
  }
  EXPECT_EQ(glyph_pixel('\x01', 2, 0), glyph_pixel('?', 2, 0));
  EXPECT_FALSE(glyph_pixel('A', 5, 0));
}

TEST(Canvas, PngReadsBack) {
  const TempDir dir;
  Canvas canvas(7, 5, Colour(0, 0, 0));
  canvas.fill(2, 1, 3, 2, Colour(1, 0.5F, 0));
  canvas.fill(-5, -5, 6, 6, Colour(0, 0, 1));  // cut off at the border
  const auto file = dir.path() / "a.png";
  ASSERT_TRUE(canvas.write_png(file));
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&image, file.c_str()), 0);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0);
  ASSERT_EQ(image.width, 7U);
  ASSERT_EQ(image.height, 5U);
  const auto pixel = [&](std::size_t x, std::size_t y) {
    return std::vector<int>{bytes[3 * (7 * y + x)], bytes[3 * (7 * y + x) + 1], bytes[3 * (7 * y + x) + 2]};
  };
  EXPECT_EQ(pixel(2, 1), (std::vector<int>{255, 128, 0}));
  EXPECT_EQ(pixel(5, 1), (std::vector<int>{0, 0, 0}));
  EXPECT_EQ(pixel(0, 0), (std::vector<int>{0, 0, 255}));
  EXPECT_EQ(pixel(1, 1), (std::vector<int>{0, 0, 0}));
}

TEST(Canvas, AFileThatCannotBeWrittenIsAnError) {
  const auto written = Canvas(2, 2, Colour::Zero()).write_png("/no/such/folder/a.png");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::unavailable);
}

/// The mean place of the pixels in which one colour channel outweighs the others.
Eigen::Vector2d centre_of(const Canvas& canvas, int channel) {
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (int y = 0; y < canvas.height(); ++y)
    for (int x = 0; x < canvas.width(); ++x) {
      const Colour& c = canvas.at(x, y);
      if (c[channel] < 0.3F || c[(channel + 1) % 3] > 0.2F || c[(channel + 2) % 3] > 0.2F) continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
    }
  return count > 0 ? Eigen::Vector2d(sum / count) : Eigen::Vector2d(-1, -1);
}

Points patch(float x, float y) {
  Points points;
  for (int row = 0; row < 20; ++row)
    for (int column = 0; column < 20; ++column)
      points.emplace_back(x + 0.05F * static_cast<float>(column), y + 0.05F * static_cast<float>(row), 0.0F);
  return points;
}

TEST(TopView, XIsToTheRightAndYUpAndPosesAreApplied) {
  TopView view{.title = "t", .subtitle = "", .panels = {{"p", {}}}, .legend = {}, .width_px = 400};
  view.panels[0].layers.push_back({.points = patch(0, 0), .trajectory = {}, .colour = Colour(1, 0, 0)});
  view.panels[0].layers.push_back({.points = patch(10, 5), .trajectory = {}, .colour = Colour(0, 1, 0)});
  Canvas canvas = draw(view);
  const Eigen::Vector2d red = centre_of(canvas, 0), green = centre_of(canvas, 1);
  ASSERT_GT(red.x(), 0);
  EXPECT_GT(green.x(), red.x() + 50);
  EXPECT_LT(green.y(), red.y() - 25);
  view.panels[0].layers[1].T_view_cloud.translation() = Eigen::Vector3d(-20, 0, 0);
  canvas = draw(view);
  EXPECT_LT(centre_of(canvas, 1).x(), centre_of(canvas, 0).x() - 50);
}

TEST(TopView, EmptyViewsAreDrawn) {
  EXPECT_EQ(draw({.title = "", .subtitle = "", .panels = {}, .legend = {}}).width(), 1600);
  EXPECT_EQ(draw({.title = "", .subtitle = "", .panels = {{"nothing", {}}, {"", {{}}}}, .legend = {}}).width(), 1600);
}

}  // namespace
}  // namespace headframe::picture
