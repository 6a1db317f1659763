// Plans on paper: sizes, scales, and what the files hold.

#include "server/operator/plan.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <nlohmann/json.hpp>

#include "server/operator/trajectory_export.hpp"
#include "tests/support/fake_station.hpp"

namespace headframe {
namespace {

Eigen::AlignedBox2d box(double width_m, double height_m) {
  return {Eigen::Vector2d(1000, -50), Eigen::Vector2d(1000 + width_m, height_m - 50)};
}

TEST(PlanPaper, HoldsTheWholeBoxAtItsScale) {
  for (const int scale : {0, 200, 500, 2000})
    for (const auto& [width_m, height_m] :
         {std::pair(3.0, 3.0), std::pair(90.0, 20.0), std::pair(20.0, 90.0), std::pair(150.0, 149.0)}) {
      const auto paper = plan_paper(box(width_m, height_m), scale);
      ASSERT_TRUE(paper) << paper.error().message;
      EXPECT_EQ(paper->scale, scale > 0 ? scale : paper->scale);
      for (const auto& [x_m, y_m] : {std::pair(1000.0, -50.0), std::pair(1000 + width_m, height_m - 50)}) {
        const auto [x, y] = paper->at({x_m, y_m});
        EXPECT_GE(x, paper->map_x_mm);
        EXPECT_LE(x, paper->map_x_mm + paper->map_width_mm);
        EXPECT_GE(y, paper->map_y_mm);
        EXPECT_LE(y, paper->map_y_mm + paper->map_height_mm);
      }
      const auto p = paper->at({1000, 0}), q = paper->at({1010, 0});
      EXPECT_NEAR(q[0] - p[0], 10000.0 / paper->scale, 1e-9) << "ten metres on paper";
    }
}

TEST(PlanPaper, IsTheSmallestThatHoldsItAndTurned) {
  EXPECT_EQ(plan_paper(box(100, 50), 500)->name, "A4");
  EXPECT_GT(plan_paper(box(100, 50), 500)->width_mm, plan_paper(box(100, 50), 500)->height_mm);
  EXPECT_EQ(plan_paper(box(50, 100), 500)->height_mm, 297);
  EXPECT_EQ(plan_paper(box(150, 50), 500)->name, "A3");
  EXPECT_EQ(plan_paper(box(500, 300), 500)->name, "A0");
}

TEST(PlanPaper, SaysWhichScaleWouldFit) {
  const auto small = plan_paper(box(900, 300), 200);
  ASSERT_FALSE(small);
  EXPECT_NE(small.error().message.find("give a scale of 1000"), std::string::npos) << small.error().message;
  EXPECT_FALSE(plan_paper(box(900e3, 300), 0));
}

std::string written(PlanRequest request, double first_stamp_s = 0) {
  FakeStation station;
  station.floor = true;
  station.first_stamp_s = first_stamp_s;
  request.component = 1;
  Plan plan(station, request);
  std::string out;
  for (;;) {
    auto piece = plan.next();
    EXPECT_TRUE(piece) << piece.error().message;
    if (!piece || !*piece) return out;
    out += **piece;
  }
}

TEST(Plan, SvgHasScaleNorthDateAndNames) {
  const std::string svg = written({.format = PlanFormat::svg, .scale = 500});
  for (const char* words : {"1:500", "own frame: x, y in metres", "roof cut", ">alpha<", ">beta<", "made 20",
                            "revision 7", "data:image/png;base64,iVBOR"})
    EXPECT_NE(svg.find(words), std::string::npos) << words;
  EXPECT_EQ(svg.find("width=\"297mm\" height=\"210mm\"") != std::string::npos ||
                svg.find("width=\"210mm\" height=\"297mm\"") != std::string::npos,
            true);
  EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
}

TEST(Plan, SessionsHaveTheDayOfTheirStampsWhereACalendarHasIt) {
  const PlanRequest svg{.format = PlanFormat::svg, .scale = 500};
  EXPECT_NE(written(svg, 1790000000).find(">alpha, 2026-09-2"), std::string::npos);
  for (const double stamp_s : {0.0, 253402300800.0, 1e289, -1e289})
    EXPECT_NE(written(svg, stamp_s).find(">alpha<"), std::string::npos) << stamp_s;
}

TEST(Path, IsJsonWhateverTheStamps) {
  FakeStation station;
  station.first_stamp_s = -1.7e308;
  const auto json = PathJson(station, 1, 1).next();
  ASSERT_TRUE(json && *json);
  EXPECT_EQ(nlohmann::json::parse(**json).at("keyframes").size(), 3U);
}

TEST(Plan, PdfIsWholeAndItsTableOfObjectsIsRight) {
  const std::string pdf = written({.format = PlanFormat::pdf, .scale = 500});
  ASSERT_EQ(pdf.substr(0, 5), "%PDF-");
  EXPECT_EQ(pdf.substr(pdf.size() - 6), "%%EOF\n");
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref\n") + 10));
  ASSERT_EQ(pdf.substr(table, 7), "xref\n0 ");
  std::size_t row = pdf.find('\n', table + 7) + 1 + 20;
  for (int object = 1; object <= 8; ++object, row += 20) {
    const std::size_t at = std::stoul(pdf.substr(row, 10));
    const std::string head = std::to_string(object) + " 0 obj";
    EXPECT_EQ(pdf.substr(at, head.size()), head);
  }
  const std::size_t begin = pdf.find("stream\n", pdf.find("4 0 obj")) + 7;
  std::string drawn(1 << 20, '\0');
  uLongf size = drawn.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(drawn.data()), &size,
                       reinterpret_cast<const Bytef*>(pdf.data() + begin), pdf.find("\nendstream", begin) - begin),
            Z_OK);
  drawn.resize(size);
  EXPECT_NE(drawn.find("(1:500) Tj"), std::string::npos);
}

TEST(Plan, NamesOfPeersAreNoMarkup) {
  picture::Sheet sheet;
  sheet.title = "a)b\\c";
  sheet.texts.push_back({10, 10, 3, "<b>&\"\x01 (\xc3\xa4 \xd0\xb6", picture::Align::left, {}, false});
  const std::string svg = *picture::sheet_svg(sheet);
  EXPECT_NE(svg.find("&lt;b&gt;&amp;&quot;? ("), std::string::npos) << svg;
  EXPECT_EQ(svg.find('\x01'), std::string::npos);
  EXPECT_NE(picture::sheet_pdf(sheet)->find("/Title(a\\)b\\\\c)"), std::string::npos);
}

TEST(Plan, ASliceLeavesOutWhatIsHigher) {
  const std::string all = written({.format = PlanFormat::svg, .scale = 500});
  const std::string none = written({.format = PlanFormat::svg, .scale = 500, .low_m = 500, .high_m = 600});
  EXPECT_LT(none.size(), all.size());
  EXPECT_NE(none.find("heights from 500.0 m to 600.0 m"), std::string::npos);
}

}  // namespace
}  // namespace headframe
