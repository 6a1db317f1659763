// What is told of placements that only their likeness to other places speaks against, and of their rivals.
#include <gtest/gtest.h>

#include "server/merge/alignment_book.hpp"
#include "server/merge/candidate_verifier.hpp"
#include "server/verification/verdict_curves.hpp"
#include "tests/support/keyframes.hpp"

namespace headframe {
namespace {

class ToldPlacement : public testing::Test {
 protected:
  void SetUp() override {
    for (const SessionId id : {1, 2}) {
      sessions_.add(id, {"test", 1});
      for (std::uint64_t m = 1; m <= 61; ++m) {
        Keyframe k = line_keyframe(m);
        k.stamp_s = static_cast<double>(m);
        sessions_.add_keyframe(id, k);
      }
      sessions_.complete(id);
      sessions_.set_looked_at(id, true);
    }
  }
  AlignmentState judged(double probability, double if_unique) {
    Judgement judgement{RegistrationStatus::converged, pose_from_yaw(0.5, {1, 2, 0}), {}};
    judgement.evidence.probability = probability;
    judgement.evidence.probability_if_unique = if_unique;
    judgement.evidence.inlier_fraction = 1;
    judgement.evidence.overlap_m = 60;
    AttemptReport report;
    book.record({1, 2}, judgement, std::nullopt, false, report);
    book.update_atlas([](SessionId, SessionId, const Pose&) { return Contact::none; },
                      [](const std::pair<SessionId, SessionId>&) { return Objection{}; }, report);
    return book.find(1, 2)->state;
  }
  double told() const { return book.find(1, 2)->evidence.probability; }

  const MergeConfig config_{};
  SessionMap sessions_{config_};
  AlignmentBook book{config_, sessions_};
};

TEST_F(ToldPlacement, IsACandidateByWhatIsTold) {
  const double told_odds = odds(config_.candidate_probability) / verdict_wrong_weight;
  const double threshold = told_odds / (1 + told_odds);
  EXPECT_EQ(judged(1.05 * threshold, 0.99), AlignmentState::candidate);
  EXPECT_GT(told(), config_.candidate_probability);
  EXPECT_EQ(judged(0.95 * threshold, 0.99), AlignmentState::rejected);
  EXPECT_LT(told(), config_.candidate_probability);
}

TEST_F(ToldPlacement, IsMergedByItsProbability) {
  EXPECT_EQ(judged(0.8999, 1), AlignmentState::candidate);
  EXPECT_LT(told(), config_.accept_probability);
  EXPECT_EQ(judged(0.9, 1), AlignmentState::published);
  EXPECT_EQ(told(), 0.9);
}

TEST_F(ToldPlacement, ThatWasWithdrawnStaysSoWhileItIsImprobable) {
  ASSERT_EQ(judged(0.99, 1), AlignmentState::published);
  for (int again = 0; again < 2; ++again) EXPECT_EQ(judged(1e-6, 0.99), AlignmentState::retracted);
  EXPECT_LT(told(), config_.candidate_probability);
  EXPECT_EQ(judged(0.3, 0.99), AlignmentState::candidate);
}

Verdict verdict(double x_m, double probability, double if_unique) {
  Verdict v;
  v.judgement.T_a_b = pose_from_yaw(0, {x_m, 0, 0});
  v.judgement.evidence.probability = probability;
  v.judgement.evidence.probability_if_unique = if_unique;
  return v;
}

TEST(NoteRival, IsTheMostProbableOfTheOthers) {
  std::vector<Verdict> verdicts{verdict(0, 0.95, 0.99), verdict(0.1, 0.9, 0.99), verdict(50, 1e-9, 0.99),
                                verdict(90, 1e-3, 0.1)};
  const auto T_rival = note_rival(verdicts);
  ASSERT_TRUE(T_rival);
  EXPECT_EQ(T_rival->translation().x(), 90) << "the second is the same placement";
  EXPECT_EQ(verdicts.front().judgement.evidence.runner_up, 1e-3);
}

TEST(NoteRival, IsNoneWhereAllAreOnePlacement) {
  std::vector<Verdict> verdicts{verdict(0, 0.95, 0.99), verdict(0.1, 0.9, 0.99)};
  EXPECT_FALSE(note_rival(verdicts));
  EXPECT_EQ(verdicts.front().judgement.evidence.runner_up, 0);
}

}  // namespace
}  // namespace headframe
