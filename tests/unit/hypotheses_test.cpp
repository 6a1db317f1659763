#include "server/place/hypotheses.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "server/place/wall_search.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
constexpr double rad_per_deg = std::numbers::pi / 180;

TEST(Hypotheses, PiecesCoverThePathAndOverlapByHalf) {
  std::vector<Keyframe> line(101);
  for (std::size_t i = 0; i < line.size(); ++i) line[i].T_local_sensor.translation().x() = 3.0 * static_cast<double>(i);
  const auto pieces = cut_pieces(line, 120);
  ASSERT_EQ(pieces.size(), 4U);
  EXPECT_EQ(pieces[0].begin, 0U);
  EXPECT_EQ(pieces[1].begin, 20U);
  EXPECT_EQ(pieces[0].end, 41U);
  EXPECT_EQ(pieces.back().end, line.size());
  EXPECT_EQ(cut_pieces(std::span(line).first(1), 120).size(), 1U);
  EXPECT_TRUE(cut_pieces({}, 120).empty());
}

TEST(Hypotheses, WallMapsFindTheTurnAndTheShift) {
  const BoxMine mine({BoxMine::drift(0, 0, 80, 0), BoxMine::drift(30, 0, 30, 40), BoxMine::drift(60, -25, 60, 0, 6)});
  const auto a = drive(mine, {{0, 0}, {30, 0}, {30, 38}}, 0, 1), b = drive(mine, {{75, 0}, {30, 0}, {30, 20}}, 2.0, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  HypothesisFinder finder({});
  const auto find = [&] { return finder.find({1, a.keyframes}, {2, b.keyframes, false, {"other", 1}}); };
  const std::vector<Hypothesis> found = find()->hypotheses;
  ASSERT_FALSE(found.empty());
  const Eigen::Vector3d at = found[0].place_b;
  EXPECT_LT((found[0].T_a_b * at - truth * at).norm(), 1.0);
  EXPECT_LT(rotation_angle_rad(found[0].T_a_b.inverse() * truth), 3 * rad_per_deg);
  for (std::size_t i = 1; i < found.size(); ++i)
    EXPECT_LE(found[i].score * std::pow(found[i].descriptors.cautious(), 2),
              found[i - 1].score * std::pow(found[i - 1].descriptors.cautious(), 2));
}

TEST(Hypotheses, OfTheCoarsePlacementsThoseThatFitBestAreRefined) {
  const BoxMine mine({BoxMine::drift(0, 0, 80, 0), BoxMine::drift(30, 0, 30, 40), BoxMine::drift(60, -25, 60, 0, 6)});
  const auto a = drive(mine, {{0, 0}, {30, 0}, {30, 38}}, 0, 1), b = drive(mine, {{75, 0}, {30, 0}, {30, 20}}, 2.0, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const SessionWalls walls_a(a.keyframes), walls_b(b.keyframes);
  const auto leads = [&](std::size_t refined) {
    LeadSeats seats;
    seats.both_orders = seats.second_part = false;
    seats.refined = refined;
    return wall_leads(walls_a, walls_b, DescriptorAgreement({}, b.keyframes), seats, 1);
  };
  EXPECT_TRUE(leads(0).empty());
  EXPECT_EQ(leads(1).size(), 2U) << "by either rule the same";
  const std::vector<Lead> few = leads(20);  // half a cell off, the right one is not the first
  EXPECT_LE(few.size(), 40U);
  EXPECT_TRUE(std::any_of(few.begin(), few.end(), [&](const Lead& lead) {
    const Eigen::Vector3d at(lead.middle_b().x(), lead.middle_b().y(), 0);
    return (lead.T_a_b() * at - truth * at).norm() < 1 &&
           rotation_angle_rad(lead.T_a_b().inverse() * truth) < 3 * rad_per_deg;
  }));
}

TEST(Hypotheses, APieceThatHardlyMeetsTheMapDoesNotHideTheOneThatFits) {
  const BoxMine mine({BoxMine::drift(0, 0, 90, 0), BoxMine::drift(30, 0, 30, 40), BoxMine::drift(60, -25, 60, 0, 6),
                      BoxMine::drift(90, 0, 90, 120), BoxMine::drift(90, 60, 130, 60)});
  const auto a = drive(mine, {{0, 0}, {60, 0}, {60, -23}}, 0, 1);
  const auto b = drive(mine, {{0, 0}, {30, 0}, {30, 38}, {30, 0}, {90, 0}, {90, 118}}, 1, 2);  // ends far from a's path
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const SessionWalls walls_a(a.keyframes), walls_b(b.keyframes);
  const Eigen::Vector3d start = position(b.keyframes[3]);
  const auto found = [&](bool second_part) {
    LeadSeats seats;
    seats.both_orders = false;
    seats.second_part = second_part;
    seats.steps.quarter_turns = 15;  // so coarse that the right placement contradicts before it is refined
    const std::vector<Lead> leads = wall_leads(walls_a, walls_b, DescriptorAgreement({}, b.keyframes), seats, 1);
    return std::any_of(leads.begin(), leads.end(), [&](const Lead& lead) {
      const Pose T = lead.T_a_b();
      return (T * start - truth * start).norm() < 1.5 && rotation_angle_rad(T.inverse() * truth) < 5 * rad_per_deg;
    });
  };
  EXPECT_FALSE(found(false)) << "the piece with the best score is one that does not meet a's walls";
  EXPECT_TRUE(found(true));
}

TEST(Hypotheses, WhereOnePathCrossesTheOtherOnAnotherLevelTheShorterIsLaidOnTheLonger) {
  const std::vector<test::Box> shared{BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30, 6)};
  const auto with = [&](std::vector<test::Box> level) {
    level.insert(level.end(), shared.begin(), shared.end());
    return BoxMine(level);
  };
  // Both pass y = 50, b above a; all of b's pieces that hold the shared junction hold this, too, but not all of a's.
  const BoxMine lower = with({BoxMine::drift(60, 0, 60, 50), BoxMine::drift(60, 50, -30, 50)});
  const BoxMine upper =
      with({BoxMine::drift(30, 30, 30, 53), BoxMine::drift(30, 53, 0, 53), BoxMine::drift(0, 53, 0, 160)});
  const auto a = drive(lower, {{0, 0}, {30, 0}, {30, 28}, {30, 0}, {60, 0}, {60, 50}, {-30, 50}}, 0, 1);
  const auto b = drive(upper, {{0, 0}, {30, 0}, {30, 53}, {0, 53}, {0, 160}}, 1, 2);
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const SessionWalls walls_a(a.keyframes), walls_b(b.keyframes);
  const Eigen::Vector3d start = position(b.keyframes[3]);
  const auto found = [&](bool both_orders) {
    LeadSeats seats;
    seats.both_orders = both_orders;
    const std::vector<Lead> leads = wall_leads(walls_a, walls_b, DescriptorAgreement({}, b.keyframes), seats, 1);
    return std::any_of(leads.begin(), leads.end(), [&](const Lead& lead) {
      const Pose T = lead.T_a_b();
      return lead.a_on_b == both_orders && (T * start - truth * start).norm() < 1.5 &&
             rotation_angle_rad(T.inverse() * truth) < 5 * rad_per_deg;
    });
  };
  EXPECT_FALSE(found(false)) << "what lies above one another contradicts";
  EXPECT_TRUE(found(true));
}

/// Parallel galleries, joined by cross-cuts: most of one lies well on most of another.
BoxMine galleries(std::mt19937& rng, std::vector<double>& y, std::vector<double>& x) {
  std::uniform_real_distribution<double> spacing_m(14, 24), along_m(20, 130);
  std::vector<test::Box> boxes;
  for (double at = 0; y.size() < 7; at += spacing_m(rng)) {
    y.push_back(at);
    x.push_back(along_m(rng));
    boxes.push_back(BoxMine::drift(0, at, 150, at));
  }
  for (std::size_t i = 0; i + 1 < y.size(); ++i) boxes.push_back(BoxMine::drift(x[i], y[i], x[i], y[i + 1]));
  return BoxMine(boxes);
}

TEST(Hypotheses, TwoDrivesThatMeetAtOneCrossCutAreProposedAmongParallelGalleries) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 rng(seed);
    std::vector<double> y, x;
    const BoxMine mine = galleries(rng, y, x);
    const double beyond_m = x[3] > x[2] ? 15 : -15;  // they share this much of a gallery, and half of a cross-cut
    const auto a = drive(mine,
                         {{5, y[0]},
                          {x[0], y[0]},
                          {x[0], y[1]},
                          {x[1], y[1]},
                          {x[1], y[2]},
                          {x[2], y[2]},
                          {x[2], y[3]},
                          {x[2] + beyond_m, y[3]}},
                         0, 1);
    const auto b =
        drive(mine, {{5, y[5]}, {x[4], y[5]}, {x[4], y[4]}, {x[3], y[4]}, {x[3], y[3]}, {x[2], y[3]}, {x[2], y[3] - 8}},
              2, 2);
    const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
    HypothesisFinder finder({});
    const auto found = finder.find({1, a.keyframes}, {2, b.keyframes, false, {"other", 1}})->hypotheses;
    const Eigen::Vector3d shared = position(b.keyframes[b.keyframes.size() - 4]);
    EXPECT_TRUE(std::any_of(found.begin(), found.end(),
                            [&](const Hypothesis& h) {
                              return (h.T_a_b * shared - truth * shared).norm() < 2 &&
                                     rotation_angle_rad(h.T_a_b.inverse() * truth) < 5 * rad_per_deg;
                            }))
        << "mine " << seed;
  }
}

TEST(Hypotheses, APairIsSearchedAgainWhenOneHasGrown) {
  const BoxMine mine({BoxMine::drift(0, 0, 80, 0), BoxMine::drift(30, 0, 30, 40)});
  const auto a = drive(mine, {{0, 0}, {60, 0}}, 0, 1), b = drive(mine, {{75, 0}, {0, 0}}, 2.0, 2);
  HypothesisFinder finder({});
  const auto version = [&](std::size_t keyframes) {
    const Found* found = finder.find({1, std::span(a.keyframes).first(keyframes)}, {2, b.keyframes});
    return found ? static_cast<int>(found->version) : -1;
  };
  EXPECT_EQ(version(10), 1);
  EXPECT_EQ(version(10), 1);
  std::size_t grown = 10;  // the first length that is 15 m more
  while (path_m(std::span(a.keyframes).first(grown)) - path_m(std::span(a.keyframes).first(10)) < 15) ++grown;
  EXPECT_EQ(version(grown - 1), 1);
  EXPECT_EQ(version(grown), 2);
  finder.allow(0);
  EXPECT_EQ(version(grown), 2) << "known: no search";
  EXPECT_EQ(version(a.keyframes.size()), -1) << "it would take one";
  finder.allow(1);
  EXPECT_EQ(version(a.keyframes.size()), 3);
}

TEST(Hypotheses, WhereCrossCutsRepeatTheDescriptorsAlongThePathSayWhich) {
  std::vector<test::Box> boxes{BoxMine::drift(0, 0, 160, 0)};
  for (double x = 10; x < 160; x += 20) boxes.push_back(BoxMine::drift(x, -12, x, 12));
  const BoxMine mine(boxes);
  auto a = drive(mine, {{20, 0}, {100, 0}}, 0, 1), b = drive(mine, {{60, 0}, {140, 0}}, 1.0, 2);
  const auto describe = [](test::Drive& d) {  // slowly changing along x, never twice the same
    for (Keyframe& k : d.keyframes) {
      const double x = (d.T_mine_local * k.T_local_sensor.translation()).x();
      k.descriptor.q.clear();
      for (const double wave_m : {23.0, 41.0, 67.0, 130.0}) {
        const double turn = 2 * std::numbers::pi * x / wave_m;
        k.descriptor.q.push_back(static_cast<float>(std::cos(turn)));
        k.descriptor.q.push_back(static_cast<float>(std::sin(turn)));
      }
    }
  };
  const Pose truth = a.T_mine_local.inverse() * b.T_mine_local;
  const auto error_of_first = [&] {
    HypothesisFinder finder({});
    const auto* found = finder.find({1, a.keyframes}, {2, b.keyframes});
    const Hypothesis& first = found->hypotheses.at(0);
    return (first.T_a_b * first.place_b - truth * first.place_b).norm();
  };
  for (test::Drive* d : {&a, &b})
    for (Keyframe& k : d->keyframes) k.descriptor = {};
  EXPECT_GT(error_of_first(), 10) << "the walls alone lay as many cross-cuts on each other as they can";
  describe(a);
  describe(b);
  EXPECT_LT(error_of_first(), 1.5);
}

TEST(Hypotheses, ThreadsDoNotChangeThem) {
  const BoxMine mine({BoxMine::drift(0, 0, 60, 0), BoxMine::drift(30, 0, 30, 30)});
  const auto a = drive(mine, {{0, 0}, {58, 0}}, 0, 1), b = drive(mine, {{30, 28}, {30, 0}}, 1, 2);
  const WallMap map_a = draw_wall_map(a.keyframes, 1), map_b = draw_wall_map(b.keyframes, 1);
  const WallField field(map_a);
  const auto one = search_walls(map_a, field, map_b, 5, {}, 1), many = search_walls(map_a, field, map_b, 5, {}, 7);
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].score, many[i].score);
}

}  // namespace
}  // namespace headframe
