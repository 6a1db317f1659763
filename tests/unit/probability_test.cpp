#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "server/merge/merge_config.hpp"
#include "server/verification/verdict_curves.hpp"
#include "server/verification/verification.hpp"
#include "tests/support/convincing_evidence.hpp"

namespace headframe {
namespace {

using test::convincing;

double p(const Evidence& e) { return probability(RegistrationStatus::converged, e); }

/// What a term is drawn over: the values of its measure from the best to the worst that occurs.
struct Measure {
  double Evidence::*member;
  double best, worst;
};

const std::vector<Measure> measures{{&Evidence::overlap_m, 200, 0},
                                    {&Evidence::worst_place_violation, 0, 0.2},
                                    {&Evidence::farther_violation, 0, 0.2},
                                    {&Evidence::rmse_m, 0, 0.3},
                                    {&Evidence::spread_m, 0, 6},
                                    {&Evidence::places_agreeing, 6, 0},
                                    {&Evidence::aliases, 0, 6},
                                    {&Evidence::repetition, 0, 2},
                                    {&Evidence::look_alikes, 0, 20},
                                    {&Evidence::mine_look_alikes, 0, 4},
                                    {&Evidence::weakest_hold, 1. / 3, 0},
                                    {&Evidence::end_on_match, 1, 0},
                                    {&Evidence::descriptors_alike, 1, 0},
                                    {&Evidence::tilt_deg, 0, 2.99},
                                    {&Evidence::mine_similar_places, 0, 1},
                                    {&Evidence::support, 1500, 1},
                                    {&Evidence::rock_in_common, 10000, 1}};

/// More path shows more walls and more rock.
void show_as_much_per_metre(Evidence& e) {
  e.support = 9 * std::max(10.0, e.overlap_m);
  e.rock_in_common = 20 * (e.overlap_m + 35);
}

TEST(Probability, EveryMeasureCountsAndWorseIsNeverBetter) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (const Measure& m : measures) {
    for (int draw = 0; draw < 50; ++draw) {
      Evidence e = convincing();  // with everything else somewhere between its best and its worst
      for (const Measure& other : measures)
        e.*other.member = std::lerp(other.best, other.worst, std::pow(share(rng), 3));
      double before = 1;
      for (double worse = 0; worse <= 1; worse += 0.02) {
        e.*m.member = std::lerp(m.best, m.worst, worse);
        if (m.member == &Evidence::overlap_m) show_as_much_per_metre(e);
        EXPECT_LE(p(e), before + 1e-12);
        before = p(e);
      }
    }
    Evidence good = convincing(), bad = convincing();
    good.*m.member = m.best;
    bad.*m.member = m.worst;
    if (m.member == &Evidence::overlap_m) show_as_much_per_metre(good), show_as_much_per_metre(bad);
    EXPECT_GT(p(good), p(bad) + 0.001);
  }
}

TEST(Probability, WhatConvinces) {
  EXPECT_GT(p(convincing()), 0.98);
  const auto with = [&](double Evidence::*member, double value) {
    Evidence e = convincing();
    e.*member = value;
    return p(e);
  };
  EXPECT_LT(with(&Evidence::worst_place_violation, 0.06), 0.01) << "rays pass through its rock";
  EXPECT_LT(with(&Evidence::farther_violation, 0.01), 0.5) << "a copy ends there";
  EXPECT_LT(with(&Evidence::spread_m, 3), 0.5) << "it slid metres along a tunnel";
  EXPECT_LT(with(&Evidence::places_agreeing, 1), 0.9);
  EXPECT_LT(with(&Evidence::descriptors_alike, 0.5), 0.9);
  EXPECT_LT(with(&Evidence::tilt_deg, 2.5), 0.9) << "it leans";
  EXPECT_EQ(with(&Evidence::tilt_deg, most_tilt_deg + 0.1), 0);
  EXPECT_GT(with(&Evidence::tilt_deg, most_tilt_deg), 0);
  EXPECT_LE(probability(RegistrationStatus::degenerate, convincing()), 0.4) << "slides: at most a candidate";
  EXPECT_EQ(probability(RegistrationStatus::too_little_overlap, convincing()), 0);
}

TEST(Probability, OverLittlePathDescriptorsHaveToAgreeTheMoreTheLessItIs) {
  const auto doubt = [](double overlap_m, double alike, double compared = 5) {
    Evidence e = convincing();
    e.overlap_m = overlap_m;
    e.descriptors_alike = alike;
    e.descriptors_compared = compared;
    const auto all = verdict_measures(e);
    return std::find_if(all.begin(), all.end(),
                        [](const VerdictTerm& t) { return t.name == "descriptors differ over little path"; })
        ->value;
  };
  EXPECT_NEAR(doubt(40, 0.72), 1, 1e-9);
  EXPECT_NEAR(doubt(40, 0.76), 0, 1e-9);
  EXPECT_NEAR(doubt(25, 0.78), 1, 1e-9);
  EXPECT_NEAR(doubt(25, 0.82), 0, 1e-9);
  EXPECT_NEAR(doubt(32, 0.76), 0, 1e-9);
  EXPECT_EQ(doubt(50, 0.6), 0);
  EXPECT_EQ(doubt(25, 0.6, 3), 0) << "too few to tell";
}

TEST(Probability, ALongOverlapMakesUpForLikenessToOtherPlaces) {
  Evidence e = convincing();
  e.overlap_m = 25;
  e.rock_in_common = 850;
  e.support = 200;
  e.look_alikes = 6;
  EXPECT_LT(p(e), 0.9) << "25 m among many that look alike";
  e = convincing();
  e.look_alikes = 6;
  e.aliases = 1;
  EXPECT_LT(p(e), 0.9);
  e.overlap_m = 100;
  e.support = 900;
  EXPECT_GT(p(e), 0.95);
}

TEST(Probability, WhatAllSessionsShowOfTheMineCountsLikeWhatThePairShows) {
  Evidence e = convincing(), of_pair = convincing();
  e.repetition = 0.3;
  EXPECT_EQ(p(e), p(convincing())) << "a copy or two in all that is known";
  e.repetition = 0.5;
  of_pair.aliases = 1;
  EXPECT_EQ(p(e), p(of_pair));
  e = of_pair = convincing();
  e.mine_look_alikes = 1;
  of_pair.look_alikes = 3;
  EXPECT_EQ(p(e), p(of_pair));
  e.look_alikes = 3;
  EXPECT_EQ(p(e), p(of_pair)) << "the same is not counted twice";
}

double term(const Evidence& e, std::string_view name) {
  const auto all = log_odds(e).contributions;
  return std::ranges::find(all, name, &VerdictTerm::name)->value;
}

TEST(Probability, WhereCopiesAreKnownDescriptorsThatAreEqualTellNoPlaces) {
  Evidence e = convincing();
  e.look_alikes = 6, e.weakest_hold = 0.015, e.descriptors_alike = 0.96;
  const double tells = term(e, "places look alike"), held = term(e, "walls hold it");
  e.repetition = copies_known / 2;
  EXPECT_EQ(term(e, "places look alike"), tells);
  e.repetition = copies_known;
  EXPECT_LT(term(e, "places look alike"), tells - 1);
  EXPECT_LT(term(e, "walls hold it"), held);
  e.descriptors_compared = 12;
  EXPECT_EQ(term(e, "places look alike"), tells) << "twelve that agree still tell";
  e.descriptors_compared = 8;
  const double as_known = term(e, "places look alike");
  e.repetition = 0, e.descriptors_alike = 0.85;
  EXPECT_EQ(term(e, "places look alike"), as_known) << "as if they were not equal";
}

TEST(Probability, InAMineOfManyLookAlikesFewEqualDescriptorsTellNoPlaces) {
  Evidence e = convincing();
  e.look_alikes = 6, e.weakest_hold = 0.015, e.descriptors_alike = 0.96, e.descriptors_compared = 8;
  e.mine_look_alikes = 1.25;
  const double tells = term(e, "places look alike");
  e.mine_look_alikes = 1.4;
  EXPECT_LT(term(e, "places look alike"), tells - 1);
  e.descriptors_compared = 12;
  EXPECT_EQ(term(e, "places look alike"), tells);
}

TEST(Probability, OverLittlePathTheWallsOfAStraightTunnelDoNotCount) {
  const auto walls = [](double overlap_m, double hold) {
    Evidence e = convincing();
    e.overlap_m = overlap_m, e.weakest_hold = hold, e.support = 140;
    e.descriptors_compared = e.descriptors_alike = 0;
    const auto all = verdict_measures(e);
    return std::ranges::find(all, "walls match", &VerdictTerm::name)->value;
  };
  EXPECT_NEAR(walls(10, 0.03), 0, 1e-9);
  EXPECT_NEAR(walls(14, 0.03), 10, 1e-9);
  EXPECT_NEAR(walls(5, 0.05), 14, 1e-9) << "not straight";
  EXPECT_NEAR(walls(5, 0.04), 7, 1e-9);
}

TEST(Probability, WhatIsNotKnownSaysNothing) {
  Evidence e = convincing();
  EXPECT_GT(term(e, "walls match"), 0);
  e.support = 1;
  EXPECT_LT(term(e, "walls match"), 0);
  e.support = 0;
  EXPECT_EQ(term(e, "walls match"), 0) << "it came from no search";
  e.rock_in_common = 10000;
  EXPECT_GT(term(e, "rock that both saw"), 0);
  e.rock_in_common = 100;
  EXPECT_LT(term(e, "rock that both saw"), 0);
  e.rock_in_common = 0;
  EXPECT_EQ(term(e, "rock that both saw"), 0) << "it was not looked at";
  e.mine_similar_places = 0;
  EXPECT_GT(term(e, "places are similar"), 0);
  e.mine_similar_places = 0.5;
  EXPECT_LT(term(e, "places are similar"), 0);
  e.mine_similar_places = Evidence{}.mine_similar_places;
  EXPECT_EQ(term(e, "places are similar"), 0) << "nobody counted them";
}

TEST(Probability, RockIsCountedPerMetreOfTunnel) {
  Evidence junction = convincing(), drift = convincing();
  junction.overlap_m = 15, drift.overlap_m = 50;
  junction.rock_in_common = drift.rock_in_common = 1200;
  EXPECT_GT(term(junction, "rock that both saw"), term(drift, "rock that both saw") + 1);
  EXPECT_DOUBLE_EQ(rock_per_metre(junction), 24);
  drift.rock_in_common = rock_as_dense(junction, drift);
  EXPECT_DOUBLE_EQ(drift.rock_in_common, 24 * 85) << "more path is shared since it was looked at";
  EXPECT_EQ(term(junction, "rock that both saw"), term(drift, "rock that both saw"));
  junction.rock_in_common = hardly_any_rock;
  EXPECT_EQ(rock_as_dense(junction, drift), hardly_any_rock) << "it was not looked at";
  const Evidence ideal = ideal_evidence();
  for (std::size_t i = 0; i < verdict_term_count; ++i)
    EXPECT_GE(log_odds(ideal).contributions[i].value, log_odds(convincing()).contributions[i].value)
        << log_odds(ideal).contributions[i].name << ": what is not known yet may be as good as anything";
}

TEST(Probability, RoughRockMayScatterMore) {
  Evidence e = convincing();
  const double usual = p(e);
  e.rmse_m *= 1.5;
  EXPECT_LT(p(e), usual);
  e.own_scatter_m *= 1.5;
  EXPECT_NEAR(p(e), usual, 1e-12) << "the points of each session scatter as much about its own surfaces";
  const auto scatter = [&] {
    const auto all = log_odds(e).contributions;
    return std::ranges::find(all, "points scatter about the surfaces", &VerdictTerm::name)->value;
  };
  e.own_scatter_m = e.rmse_m / 2;
  EXPECT_LT(scatter(), 0);
  e.own_scatter_m = 0;
  EXPECT_EQ(scatter(), 0) << "not measured";
}

TEST(Probability, FewDescriptorsSayLittle) {
  const auto with = [&](double compared, double alike) {
    Evidence e = convincing();
    e.descriptors_compared = compared;
    e.descriptors_alike = alike;
    return p(e);
  };
  EXPECT_EQ(with(0, 0), with(0, 1)) << "nothing compared, nothing said";
  EXPECT_GT(with(1, 0.5), with(3, 0.5));
  EXPECT_GT(with(3, 0.6), with(12, 0.6));
  EXPECT_LT(with(1, 0.9), with(12, 0.9));
}

/// A step of a hundredth of a curve's range moves no probability by more than .05.
TEST(Probability, HasNoCliffs) {
  for (const auto& curve : verdict_curves) {
    const double range = curve.back().at - curve.front().at;
    for (std::size_t i = 1; i < curve.size(); ++i) {
      const double step = curve[i].at - curve[i - 1].at, fall = std::abs(curve[i].log_odds - curve[i - 1].log_odds);
      if (step == 0) {
        EXPECT_EQ(fall, 0);
      } else {
        EXPECT_LT(fall * 0.01 * range / step / 4, 0.0505) << "at a probability of one half, where it moves most";
      }
    }
  }
}

/// Of measured placements: metres shared, scatter in mm, the usual scatter of such rock about its own surfaces,
/// aliases, look-alikes and those of the mine, hold, end-on match, descriptors and their similarity, score of the
/// walls. Of rock that both saw, as much as wrong placements over as much path show; the same placements are in
/// tests/bench/known_placements.csv.
Evidence measured(double overlap_m, double rmse_mm, double own_mm, double aliases, double look_alikes, double of_mine,
                  double hold, double end_on, double compared, double alike, double support,
                  double similar = Evidence{}.mine_similar_places) {
  Evidence e = convincing();
  e.spread_m = e.tilt_deg = 0.1;
  e.overlap_m = overlap_m, e.rmse_m = rmse_mm / 1000, e.own_scatter_m = own_mm / 1000;
  e.aliases = aliases, e.look_alikes = look_alikes;
  e.mine_look_alikes = of_mine, e.weakest_hold = hold, e.end_on_match = end_on;
  e.descriptors_compared = compared, e.descriptors_alike = alike, e.support = support;
  e.mine_similar_places = similar;
  e.rock_in_common = 600 + 10 * overlap_m;
  return e;
}

TEST(Probability, CopiesOfMinesThatWereMeasuredWait) {
  const double accepted = MergeConfig{}.accept_probability;
  EXPECT_LT(p(measured(19, 97, 65, 0, 0.31, 0.27, 0.052, 0.25, 5, 0.906, 181)), accepted) << "a tunnel of equal pieces";
  EXPECT_LT(p(measured(33, 90, 52, 0, 0, 0.06, 0.070, 0.62, 5, 0.762, 185)), accepted) << "nothing looks alike";
  EXPECT_LT(p(measured(16, 130, 67, 0, 0.01, 0, 0.152, 0.45, 0, 0, 174)), accepted) << "rough tunnel, no descriptors";
  EXPECT_LT(p(measured(28, 96, 58, 0, 0.83, 0, 0.035, 0.20, 7, 0.872, 251)), accepted) << "nearly straight";
  EXPECT_LT(p(measured(54, 88, 52, 3, 3.12, 1.10, 0.061, 0.54, 9, 0.779, 476)), accepted) << "beside three aliases";
  EXPECT_LT(p(measured(51, 71, 60, 0, 7.22, 1.62, 0.050, 0.71, 10, 0.913, 289)), accepted) << "one of equal tunnels";
  EXPECT_LT(p(measured(7, 111, 52, 0, 0.11, 0, 0.046, 0.31, 0, 0, 123)), accepted) << "hardly any path is shared";
  EXPECT_LT(p(measured(28, 84, 59, 0, 0, 0.14, 0.051, 0.70, 6, 0.893, 239, 0.95)), accepted)
      << "equal tunnels, none alike";
  EXPECT_LT(p(measured(9, 95, 57, 0, 0.35, 0.06, 0.059, 0.57, 0, 0, 100, 0.54)), accepted)
      << "a crossing, no descriptors";
  EXPECT_LT(p(measured(37, 108, 72, 0, 6.84, 1.43, 0.035, 0.38, 9, 0.972, 332, 4.18)), accepted)
      << "equal descriptors in a mine of many look-alikes";
  EXPECT_LT(p(measured(46, 76, 59, 0, 7.76, 1.08, 0.083, 0.60, 9, 0.933, 275, 3.57)), accepted)
      << "one of equal tunnels, not so equal descriptors";
  EXPECT_LT(p(measured(5, 124, 65, 0, 0, 0, 0.029, 0.07, 0, 0, 133, 0.03)), accepted)
      << "a straight piece among others, no descriptors";
}

}  // namespace
}  // namespace headframe
