// The measuring itself: a bench that counts wrongly is worse than none.

#include <gtest/gtest.h>

#include <numbers>

#include "tests/bench/descriptors/figures.hpp"
#include "tests/bench/descriptors/trial.hpp"

namespace headframe::bench {
namespace {

constexpr double degree = std::numbers::pi / 180;

Answer found_at(std::size_t rank, double distance) { return {.answerable = true, .rank = rank, .distance = distance}; }
Answer of_a_new_place(double distance) { return {.answerable = false, .rank = 0, .distance = distance}; }

/// A view from x on the x axis that sees the cubes of 1 m which begin at these x of a wall along it.
View view_at(double x, const std::vector<int>& cubes) {
  View view;
  view.T_world_level = pose_from_yaw(0, {x, 0, 0});
  for (const int cube : cubes) view.points_level.emplace_back(static_cast<float>(cube + 0.5 - x), 2.5F, 0.5F);
  return view;
}

/// q is the first point's z, w its y: enough to say who is near whom, and how it was turned.
class TellingFamily : public DescriptorFamily {
 public:
  FamilyId id() const override { return {"telling", 1}; }
  std::size_t q_size() const override { return 1; }
  std::size_t w_size() const override { return 1; }
  Result<Descriptor> extract(const Points& points_level) const override {
    if (points_level.empty()) return failure(ErrorCode::bad_input, "no points");
    return Descriptor{{points_level[0].z()}, {points_level[0].y()}, PlaceClass::unknown};
  }
};

/// 36 bins that are zero but for the first, and the opposite one.
std::vector<float> signature(float first, float opposite) {
  std::vector<float> w(36, 0);
  w[0] = first;
  w[18] = opposite;
  return w;
}

TEST(RightAnswer, FiveMetresAndThirtyPercentAreTheLimits) {
  EXPECT_TRUE(is_right(5, 30));
  EXPECT_FALSE(is_right(5.001, 100));
  EXPECT_FALSE(is_right(0, 29.99));
}

TEST(Truth, BothLimitsHoldForViews) {
  const std::vector<int> ten{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const Drive a{view_at(0, ten)};
  EXPECT_EQ(truth_of(a, {view_at(4.99, ten)}).right[0].size(), 1U);
  EXPECT_EQ(truth_of(a, {view_at(5.01, ten)}).right[0].size(), 0U);
  EXPECT_EQ(truth_of(a, {view_at(1, {7, 8, 9, 10, 11, 12, 13, 14, 15, 16})}).right[0].size(), 1U);   // 3 of 10
  EXPECT_EQ(truth_of(a, {view_at(1, {8, 9, 10, 11, 12, 13, 14, 15, 16, 17})}).right[0].size(), 0U);  // 2 of 10
  EXPECT_EQ(truth_of(a, {view_at(1, {7, 8, 9})}).right[0].size(), 1U);  // all of the smaller one
  EXPECT_EQ(truth_of({view_at(0, {19})}, {view_at(0, {19})}).right[0].size(), 1U);
  EXPECT_EQ(truth_of({view_at(0, {20})}, {view_at(0, {20})}).right[0].size(), 0U);  // beyond 20 m nothing counts
}

TEST(Recall, CountsQueriesWithARightAnswerOnly) {
  const Answers answers{found_at(1, 1), found_at(2, 1), found_at(6, 1), found_at(0, 1), of_a_new_place(1)};
  EXPECT_EQ(count_queries(answers), 4U);
  EXPECT_DOUBLE_EQ(recall(answers, 1), 0.25);
  EXPECT_DOUBLE_EQ(recall(answers, 5), 0.5);
  EXPECT_DOUBLE_EQ(recall(answers, 6), 0.75);
  EXPECT_DOUBLE_EQ(recall(answers, 1000), 0.75);
  EXPECT_DOUBLE_EQ(recall({of_a_new_place(1)}, 1), -1);
}

TEST(TradeOff, FirstNeighboursAreTakenByDistance) {
  // By distance: right, wrong, right and new together, right, new.
  const Answers answers{found_at(1, 4), of_a_new_place(9), found_at(1, 1),
                        found_at(3, 2), found_at(1, 3),    of_a_new_place(3)};
  const auto curve = trade_off(answers);
  ASSERT_EQ(curve.size(), 5U);
  const std::vector<std::pair<double, double>> wanted{{0.25, 1}, {0.25, 0.5}, {0.5, 0.5}, {0.75, 0.6}, {0.75, 0.5}};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_DOUBLE_EQ(curve[i].recall, wanted[i].first) << i;
    EXPECT_DOUBLE_EQ(curve[i].precision, wanted[i].second) << i;
  }
  EXPECT_DOUBLE_EQ(precision_at_full_recall(answers), 0.6);
  EXPECT_DOUBLE_EQ(precision_at_full_recall({found_at(2, 1)}), 0);
  EXPECT_DOUBLE_EQ(precision_at_full_recall({of_a_new_place(1)}), -1);
  EXPECT_DOUBLE_EQ(precision_at_full_recall({found_at(0, std::numeric_limits<double>::infinity())}), 0);
}

TEST(Yaw, TenDegreesAreTheLimit) {
  Answer at_limit = found_at(1, 1), beyond = found_at(1, 1);
  at_limit.yaw_error_deg = 170;
  at_limit.yaw_top2_error_deg = 10;
  beyond.yaw_error_deg = beyond.yaw_top2_error_deg = 10.01;
  EXPECT_DOUBLE_EQ(share_top2_within_10deg({at_limit, beyond, found_at(1, 1)}), 0.5);
  EXPECT_EQ(yaw_errors_deg({at_limit, beyond, found_at(1, 1)}), (std::vector<double>{170, 10.01}));
  EXPECT_DOUBLE_EQ(share_top2_within_10deg({found_at(1, 1)}), -1);
}

TEST(ClassCount, F1IsTheHarmonicMean) {
  ClassCount count;
  EXPECT_DOUBLE_EQ(count.f1(), -1);
  for (int i = 0; i < 6; ++i) count.add(true, true);
  for (int i = 0; i < 2; ++i) count.add(false, true);
  for (int i = 0; i < 4; ++i) count.add(true, false);
  for (int i = 0; i < 100; ++i) count.add(false, false);
  EXPECT_DOUBLE_EQ(count.f1(), 2 * 0.75 * 0.6 / (0.75 + 0.6));
  EXPECT_EQ(count.others, 100U);
}

TEST(Ask, RanksTheFirstRightNeighbourAndJudgesItsYaw) {
  const TellingFamily family;
  // The best yaw between the third of a and the first of b is 180 deg, the next best 0. The fourth of a and the second
  // of b were refused by the family.
  const auto one_way = signature(1, 0), turned_round = signature(0.6F, 1);
  const std::vector<Descriptor> a{{{0}, one_way}, {{1}, one_way}, {{5}, one_way}, {{}, {}}},
      b{{{0.2F}, turned_round}, {{}, {}}};
  const Truth truth{{{2, 3}, {0}}, {0, 0, 0.25, 0}, {0.25 + 3 * degree, 0}};
  const Answers answers = ask(family, a, b, truth);
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0].rank, 3U);
  EXPECT_NEAR(answers[0].distance, 0.04, 1e-6);
  EXPECT_NEAR(answers[0].yaw_error_deg, 177, 1e-6);
  EXPECT_NEAR(answers[0].yaw_top2_error_deg, 3, 1e-6);
  EXPECT_TRUE(answers[1].answerable);
  EXPECT_EQ(answers[1].rank, 0U);
  EXPECT_EQ(recall(answers, 20), 0.5);
}

TEST(Describe, TurnsTheRobotAndRoundsAsTheWireDoes) {
  View view;
  view.points_level = {{3, 0, 1.0001F}};
  const auto straight = describe(TellingFamily(), {view, View{}}),
             left = describe(TellingFamily(), {view}, 90 * degree);
  EXPECT_EQ(straight[0].q[0], 1.0F);  // binary16 has 11 bits
  EXPECT_TRUE(straight[1].q.empty());
  EXPECT_NEAR(left[0].w[0], -3, 1e-3);  // what was ahead is now on the right
  EXPECT_EQ(wire_bytes(straight[0]), 4U);
}

TEST(Tilted, TurnsScansByTenDegreesAboutAHorizontalAxis) {
  View view;
  view.points_level = {{0, 0, 7}};
  const Drive out = tilted({view, view}, 1);
  for (const View& v : out) EXPECT_NEAR(v.points_level[0].z(), 7 * std::cos(10 * degree), 1e-5);
  EXPECT_GT((out[0].points_level[0] - out[1].points_level[0]).norm(), 1e-3);
}

TEST(Json, HasTheNamesThatAreAskedFor) {
  FamilyFigures figures;
  Answer answer = found_at(2, 1);
  answer.yaw_error_deg = answer.yaw_top2_error_deg = 1;
  figures.add("same", {answer});
  figures.add("cross", {found_at(1, 1)});
  figures.add("same", {found_at(1, 1)});
  auto json = to_json(figures);
  EXPECT_EQ(json["recall1"]["same"], 0.5);
  EXPECT_EQ(json["recall20"]["same"], 1);
  EXPECT_EQ(json["queries"]["same"], 2);
  EXPECT_EQ(json["yaw_p50_deg"], 1);
  EXPECT_EQ(json["yaw_p95_deg"], 1);
  EXPECT_EQ(json["yaw_top2_within_10deg"], 1);
  EXPECT_FALSE(json["yaw"].contains("cross"));
  EXPECT_FALSE(json.contains("junction_f1"));
  figures.tells_class = true;
  figures.junctions.add(true, true);
  EXPECT_EQ(to_json(figures)["junction_f1"], 1);
}

}  // namespace
}  // namespace headframe::bench
