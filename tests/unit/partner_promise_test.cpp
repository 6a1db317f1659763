// Which of many sessions are worth an attempt, by walls and descriptors alone.
#include "server/merge/partner_promise.hpp"

#include <gtest/gtest.h>

#include "server/merge/pair_search.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe {
namespace {

using test::BoxMine;
using test::Drive;

const FamilyId scans{"scans", 1}, other_scans{"other scans", 1};

BoxMine crossing() {
  return BoxMine({BoxMine::drift(0, 0, 90, 0), BoxMine::drift(30, 0, 30, 45), BoxMine::drift(60, -30, 60, 0, 6)});
}

/// A drift like no other: its width, and a room at a place of its own.
Drive elsewhere(int number) {
  const double n = number;
  return test::drive(
      BoxMine({BoxMine::drift(0, 0, 70, 0, 3 + 0.4 * n), BoxMine::drift(10 + 3 * n, 0, 10 + 3 * n, 9, 8)}),
      {{2, 0}, {68, 0}}, 0.1 * n, static_cast<unsigned>(number));
}

struct Sessions {
  MergeConfig config;
  SessionMap sessions{config};
  HypothesisFinder finder{finder_config(config)};
  PartnerPromise partners{config, sessions, finder};

  explicit Sessions(int partners_at_least)
      : config{[&] {
          MergeConfig c;
          c.partners = partners_at_least;
          return c;
        }()} {}

  void add(SessionId id, const Drive& drive, const FamilyId& of = scans, std::size_t keyframes = 1000) {
    if (!sessions.contains(id)) sessions.add(id, of);
    for (const Keyframe& k : drive.keyframes)
      if (k.sequence > sessions.at(id).keyframes.size() && k.sequence <= keyframes) sessions.add_keyframe(id, k);
  }
  void complete() {
    for (const auto& [id, session] : sessions.all()) sessions.complete(id);
  }
  double promise(SessionId one, SessionId other) {
    const OrderedPair p = sessions.ordered(one, other);
    const auto of = [&](SessionId id) { return PairSearch::view(id, sessions.at(id)); };
    return finder.promises(std::vector{std::pair{of(p.a), of(p.b)}}).front();
  }
};

TEST(PartnerPromise, SharedTunnelsComeFirstAndWhatPromisesNothingIsLeftOut) {
  Sessions s(16);
  s.add(1, test::drive(crossing(), {{0, 0}, {30, 0}, {30, 42}}, 0, 1));
  s.add(2, test::drive(crossing(), {{88, 0}, {30, 0}, {30, 40}}, 2, 2));
  for (int i = 3; i <= 8; ++i) s.add(i, elsewhere(i));
  s.add(9, test::drive(BoxMine({BoxMine::drift(0, 0, 6, 0, 2)}), {{1, 0}, {5, 0}}, 0, 9));  // hardly any walls
  s.complete();
  const std::vector<SessionId> ranked{9, 8, 7, 6, 5, 4, 3, 2};
  const auto chosen = s.partners.choose(1, ranked);
  ASSERT_TRUE(chosen);
  ASSERT_FALSE(chosen->empty());
  EXPECT_EQ(chosen->front(), 2);
  std::map<SessionId, double> worth;
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    const double promise = s.promise(1, ranked[i]);
    worth[ranked[i]] = promise / (8 + static_cast<double>(i));
    EXPECT_EQ(std::find(chosen->begin(), chosen->end(), ranked[i]) != chosen->end(), promise >= 20) << ranked[i];
  }
  EXPECT_EQ(std::find(chosen->begin(), chosen->end(), 9), chosen->end());
  for (std::size_t i = 1; i < chosen->size(); ++i) EXPECT_GE(worth.at((*chosen)[i - 1]), worth.at((*chosen)[i]));
}

TEST(PartnerPromise, OfMoreThanSixteenOthersNineMayComeToNothing) {
  EXPECT_EQ(MergeConfig{}.most_in_vain(16), 16) << "all are tried";
  EXPECT_EQ(MergeConfig{}.most_in_vain(17), 9);
}

TEST(PartnerPromise, EightPairsAreSearchedAtOnceAndOnlyAgainAfterGrowth) {
  Sessions s(16);
  const Drive own = test::drive(crossing(), {{0, 0}, {88, 0}}, 0, 1);
  constexpr std::size_t some = 20;  // 57 m
  s.add(1, own, scans, some);
  std::vector<SessionId> others;
  for (int i = 2; i <= 10; ++i) {
    s.add(i, elsewhere(i));
    s.sessions.complete(i);
    others.push_back(i);
  }
  EXPECT_FALSE(s.partners.choose(1, others)) << "nine are to be searched";
  EXPECT_TRUE(s.partners.choose(1, others));
  s.add(1, own, scans, some + 3);  // 9 m more
  EXPECT_TRUE(s.partners.choose(1, others)) << "too little news";
  s.add(1, own, scans, some + 6);  // 18 m more
  EXPECT_FALSE(s.partners.choose(1, others));
  EXPECT_TRUE(s.partners.choose(1, others));
  s.partners.forget(1);
  EXPECT_FALSE(s.partners.choose(1, others)) << "its poses moved";
}

TEST(PartnerPromise, TwiceAsManyAreComparedAsPartnersAndOtherFamiliesAmongThemselves) {
  Sessions s(2);
  s.add(1, test::drive(crossing(), {{0, 0}, {30, 0}, {30, 42}}, 0, 1));
  for (int i = 2; i <= 6; ++i) s.add(i, elsewhere(i));
  s.add(7, test::drive(crossing(), {{88, 0}, {30, 0}, {30, 40}}, 2, 2));
  s.add(8, test::drive(crossing(), {{88, 0}, {30, 0}, {30, 40}}, 1, 3), other_scans);
  s.complete();
  const auto chosen = s.partners.choose(1, {2, 3, 4, 5, 6, 7, 8});
  ASSERT_TRUE(chosen);
  EXPECT_EQ(std::count(chosen->begin(), chosen->end(), 6), 0) << "the fifth of its family";
  EXPECT_EQ(std::count(chosen->begin(), chosen->end(), 7), 0) << "the sixth";
  EXPECT_EQ(chosen->back(), 8) << "last, though it promises most";
  EXPECT_EQ(s.partners.choose(1, {7, 2, 3, 4, 5, 6, 8})->front(), 7);
}

TEST(PartnerPromise, AShortSessionThatStillGrowsIsNotSearched) {
  Sessions s(16);
  s.add(1, test::drive(crossing(), {{0, 0}, {88, 0}}, 0, 1));
  s.add(2, test::drive(crossing(), {{88, 0}, {30, 0}}, 2, 2), scans, 12);  // 33 m
  EXPECT_TRUE(s.partners.choose(1, {2})->empty());
  s.sessions.complete(2);
  EXPECT_EQ(*s.partners.choose(1, {2}), std::vector<SessionId>{2});
}

}  // namespace
}  // namespace headframe
