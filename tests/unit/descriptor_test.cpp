#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/descriptor/family.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
constexpr double degree = std::numbers::pi / 180;

Points turned_by(const Points& scan, double turn_deg) {
  Points turned;
  turned.reserve(scan.size());
  for (const auto& p : scan)
    turned.push_back((pose_from_yaw(-turn_deg * degree, {0, 0, 0}) * p.cast<double>()).cast<float>());
  return turned;
}

double distance(const std::vector<float>& p, const std::vector<float>& q) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (p[i] - q[i]) * (p[i] - q[i]);
  return std::sqrt(sum);
}

class EveryFamily : public testing::TestWithParam<std::string> {
 protected:
  const std::unique_ptr<DescriptorFamily> family = make_family(GetParam()).value();
  const BoxMine crossing{{BoxMine::drift(-30, 0, 30, 0), BoxMine::drift(0, 0, 0, 30)}};
  const BoxMine bend{{BoxMine::drift(-30, 0, 3, 0, 6), BoxMine::drift(3, 0, 3, 30, 6)}};
  std::mt19937 rng{1};

  Descriptor describe(const Points& scan) const { return family->extract(scan).value(); }
  Points seen(const BoxMine& mine, double x, double yaw) {
    return mine.scan(pose_from_yaw(yaw, {x, 0.3, 1.2}), rng, 0.01, 32, 720);
  }
};

TEST_P(EveryFamily, HasTheSizesItStates) {
  const Descriptor d = describe(seen(crossing, 1, 0.2));
  EXPECT_EQ(d.q.size(), family->q_size());
  EXPECT_EQ(d.w.size(), family->w_size());
  for (const float v : d.q) EXPECT_TRUE(std::isfinite(v));
}

TEST_P(EveryFamily, ATurnKeepsQAndShiftsW) {
  const Points scan = seen(crossing, 1, 0.2);
  const Descriptor a = describe(scan), elsewhere = describe(seen(bend, 1, 0.2));
  for (const double turn_deg : {30.0, 90.0, -126.0, 177.0}) {
    const Descriptor b = describe(turned_by(scan, turn_deg));
    EXPECT_LT(distance(a.q, b.q), 0.2 * distance(a.q, elsewhere.q)) << turn_deg;
    const auto yaws = family->yaw_difference(a.w, b.w, 2);
    ASSERT_FALSE(yaws.empty());
    EXPECT_NEAR(wrap_rad(yaws[0].yaw_rad - turn_deg * degree), 0, 4 * degree) << turn_deg;
  }
}

TEST_P(EveryFamily, APlaceSeenAgainFromNearbyIsNearerThanAnother) {
  const Descriptor a = describe(seen(crossing, 1, 0.2)), again = describe(seen(crossing, 1.5, -1.1)),
                   other = describe(seen(bend, 1, 0.2));
  EXPECT_LT(distance(a.q, again.q), distance(a.q, other.q));
}

TEST_P(EveryFamily, FortyNinePointsAreTooFewAndFiftyAtOnePlaceAreNot) {
  EXPECT_EQ(family->extract({}).error().code, ErrorCode::bad_input);
  EXPECT_EQ(family->extract(Points(49, Eigen::Vector3f(1, 1, 1))).error().code, ErrorCode::bad_input);
  EXPECT_TRUE(family->extract(Points(50, Eigen::Vector3f(1, 1, 0.1F))));
}

TEST_P(EveryFamily, PointsAnywhereDoNoHarm) {
  Points scan(60, Eigen::Vector3f(0, 0, 0));
  for (int i = 0; i < 30; ++i)
    scan[static_cast<std::size_t>(i)] = Eigen::Vector3f(i % 2 == 0 ? -1e30F : 1e-30F, 1e5F, i % 3 == 0 ? 1e38F : -0.0F);
  const auto d = family->extract(scan);
  ASSERT_TRUE(d) << d.error().message;
  for (const float v : d->q) EXPECT_TRUE(std::isfinite(v));
  for (const float v : d->w) EXPECT_TRUE(std::isfinite(v));
}

#ifdef HEADFRAME_NETWORKS
const std::vector<std::string> built{"learned", "scan_context", "lidar_iris"};
#else
const std::vector<std::string> built{"scan_context", "lidar_iris"};

TEST(Families, ABuildWithoutNetworksSaysSo) {
  const auto learned = make_family("learned");
  ASSERT_FALSE(learned);
  EXPECT_EQ(learned.error().code, ErrorCode::not_found);
  EXPECT_NE(learned.error().message.find("this build has no networks"), std::string::npos) << learned.error().message;
}
#endif

INSTANTIATE_TEST_SUITE_P(Families, EveryFamily, testing::ValuesIn(built), [](const auto& name) { return name.param; });

TEST(Families, AnUnknownNameIsRefusedWithTheNamesThereAre) {
  const auto none = make_family("none such");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::not_found);
  EXPECT_NE(none.error().message.find("lidar_iris"), std::string::npos) << none.error().message;
}

}  // namespace
}  // namespace headframe
