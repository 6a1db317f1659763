// Which clouds are asked for while a placement is in doubt.
#include "server/merge/cloud_requests.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

/// What is stored is with the server, all else with the robots.
class Shelves : public CloudSource {
 public:
  std::set<KeyframeRef> stored;
  CloudState state(const KeyframeRef& k) const override {
    return stored.contains(k) ? CloudState::stored : CloudState::obtainable;
  }
  Result<CloudDecoder> load(const KeyframeRef&) override { return failure(ErrorCode::not_found, "none is needed"); }
};

/// Session 1 drives 60 m along a line, session 2 its first 20 m.
class RequestsInDoubt : public testing::Test {
 protected:
  void SetUp() override {
    for (const auto& [id, metres] : {std::pair<SessionId, int>{1, 60}, {2, 20}}) {
      sessions_.add(id, {"test", 1});
      for (int m = 0; m <= metres; ++m) {
        Keyframe k = line_keyframe(static_cast<std::uint64_t>(m) + 1);
        k.stamp_s = m;
        sessions_.add_keyframe(id, k);
      }
      sessions_.complete(id);
    }
  }
  /// Sequences asked of session 1, for a placement of which everything so far speaks, but over too little.
  std::set<std::uint64_t> asked(double contradicted = 0) {
    const Case c = requests_.make_case(1, 2, {.T_a_b = Pose::Identity()}, shelves_);
    Judgement judged;
    judged.status = RegistrationStatus::converged;
    judged.T_a_b = Pose::Identity();
    Evidence& e = judged.evidence;
    e.pairs = 12;
    e.places = e.places_agreeing = 6;
    e.inlier_fraction = 0.8;
    e.worst_place_violation = contradicted;
    e.residual_m = 0.02;
    e.weakest_hold = 0.1;
    std::set<std::uint64_t> out;
    for (const KeyframeRef& k : requests_.clouds_for_verdict({1, 2}, c, judged, {10, 0, 0})) {
      EXPECT_EQ(shelves_.state(k), CloudState::obtainable);
      if (k.session == 1) out.insert(k.sequence);
    }
    return out;
  }
  std::vector<KeyframeRef> to_settle(double spread_m = 0) {
    const Case c = requests_.make_case(1, 2, {.T_a_b = Pose::Identity()}, shelves_);
    return requests_.clouds_to_settle({1, 2}, c, spread_m);
  }
  std::vector<KeyframeRef> for_another_look() {
    const Case c = requests_.make_case(1, 2, {.T_a_b = Pose::Identity(), .place_b = {10, 0, 0}}, shelves_);
    return requests_.clouds_for_further_screening({1, 2}, c);
  }
  static std::set<std::uint64_t> of(const std::vector<KeyframeRef>& wanted, SessionId id) {
    std::set<std::uint64_t> out;
    for (const KeyframeRef& k : wanted)
      if (k.session == id) out.insert(k.sequence);
    return out;
  }
  void bring(std::uint64_t first, std::uint64_t last) {
    for (const SessionId id : {1, 2})
      for (std::uint64_t s = first; s <= last; ++s) shelves_.stored.insert({id, s});
  }

  MergeConfig config_;
  SessionMap sessions_{config_};
  CloudRequests requests_{config_, sessions_};
  Shelves shelves_;
};

constexpr std::uint64_t last_that_meets = 30;  // nearer than 10 m to the end of session 2, at 21 m

TEST_F(RequestsInDoubt, AreForWhereTheTwoMeetFirst) {
  const auto sequences = asked();
  ASSERT_FALSE(sequences.empty());
  EXPECT_LE(*sequences.rbegin(), last_that_meets);
}

TEST_F(RequestsInDoubt, AreForThoseThatLookOnFromFartherOffNext) {
  bring(1, last_that_meets - 1);
  EXPECT_EQ(asked(), std::set<std::uint64_t>{last_that_meets}) << "one is left where they meet";
  bring(last_that_meets, last_that_meets);
  const auto sequences = asked();
  ASSERT_FALSE(sequences.empty());
  EXPECT_EQ(*sequences.begin(), last_that_meets + 1) << "the nearest first";
  bring(1, 61);
  EXPECT_TRUE(asked().empty());
}

TEST_F(RequestsInDoubt, AreNoneForWhatCanNotBeBelieved) {
  bring(1, last_that_meets);
  EXPECT_TRUE(asked(0.05).empty());
}

TEST_F(RequestsInDoubt, AreForTwoFurtherPlacesWhereTheFirstSaysNothing) {
  std::set<std::uint64_t> seen;
  for (std::size_t place = 0; place < JudgeConfig{}.further_places; ++place) {
    const auto wanted = for_another_look();
    const std::set<std::uint64_t> around = of(wanted, 2);
    const auto enough = static_cast<std::size_t>(config_.clouds_requested);
    ASSERT_EQ(around.size(), enough);
    EXPECT_EQ(of(wanted, 1).size(), enough) << "of both";
    EXPECT_LT(*around.rbegin() - *around.begin(), enough) << "around one place";
    for (const std::uint64_t s : around) {
      EXPECT_TRUE(seen.insert(s).second) << "another each time";
      EXPECT_GT(std::abs(static_cast<double>(s) - 11), 4) << "and not the first, at 11";
    }
    for (const KeyframeRef& k : wanted) shelves_.stored.insert(k);
  }
  EXPECT_TRUE(for_another_look().empty());
}

TEST_F(RequestsInDoubt, OfAMergeThatIsSettledAreForOneOfEachSessionAtEveryPlaceWhereNoneIsNear) {
  const std::vector<KeyframeRef> all = to_settle();
  const std::set<std::uint64_t> places = of(all, 2);
  EXPECT_EQ(places.size(), 5U) << "both ends, the middle, and between them";
  EXPECT_TRUE(places.contains(1) && places.contains(21));
  EXPECT_EQ(of(all, 1), places) << "of both sessions the same";
  EXPECT_EQ(all.size(), 2 * places.size());
  shelves_.stored = {{1, 24}};
  EXPECT_FALSE(of(to_settle(), 1).contains(21)) << "one 3 m off is near";
  shelves_.stored = {{1, 25}};
  EXPECT_TRUE(of(to_settle(), 1).contains(21));
  shelves_.stored = {all.begin(), all.end()};
  EXPECT_TRUE(to_settle().empty()) << "when they have come nothing more is asked";
}

TEST_F(RequestsInDoubt, OfAMergeOfSessionsThatDriftedAreForAllOfTheOverlap) {
  EXPECT_EQ(to_settle(0.079).size(), to_settle().size());
  const std::vector<KeyframeRef> all = to_settle(0.081);
  EXPECT_EQ(of(all, 2).size(), 21U) << "all of the shorter";
  EXPECT_EQ(of(all, 1).size(), 36U) << "and those of the longer that are less than 16 m from its end, at 20 m";
  shelves_.stored = {all.begin(), all.end()};
  EXPECT_TRUE(to_settle(0.081).empty());
}

}  // namespace
}  // namespace headframe
