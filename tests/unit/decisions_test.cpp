#include "server/atlas/decisions.hpp"

#include <gtest/gtest.h>

#include "server/atlas/merge_graph.hpp"

namespace headframe {
namespace {

constexpr double rad = 3.14159265358979 / 180;

Alignment alignment(AlignmentState verdict = AlignmentState::candidate) {
  Alignment k{7, 1, 2, verdict, pose_from_yaw(0.5, {10, 20, 0}), {}};
  k.verdict = verdict;
  k.evidence.inlier_fraction = 0.8;
  k.evidence.seen_points = 5000;
  return k;
}

/// Decides, and lets the alignment follow as the pipeline does.
Result<std::optional<DecisionRecord>> decide(DecisionBook& book, Alignment& k, Decision decision) {
  auto record = book.decide(k, decision);
  k.ruling = book.ruling(k);
  k.state = decided_state(k);
  const std::vector<SessionId> sessions{1, 2};
  k.state = merge_sessions(sessions, std::span(&k, 1)).states[0];
  return record;
}

Pose moved(const Pose& T, double metres, double degrees) { return T * pose_from_yaw(degrees * rad, {metres, 0, 0}); }

TEST(Decisions, ConfirmPublishesWhateverTheEvidenceSaysAndUndoReturnsToIt) {
  for (const auto verdict : {AlignmentState::rejected, AlignmentState::candidate, AlignmentState::verified}) {
    DecisionBook book;
    Alignment k = alignment(verdict);
    ASSERT_TRUE(decide(book, k, Decision::confirm));
    EXPECT_EQ(k.state, AlignmentState::published);
    EXPECT_EQ(k.ruling, Ruling::confirmed);
    EXPECT_FALSE(*book.decide(k, Decision::confirm)) << "it stands already: nothing new to store";
    ASSERT_TRUE(decide(book, k, Decision::undo));
    EXPECT_EQ(k.state, verdict == AlignmentState::verified ? AlignmentState::published : verdict);
    EXPECT_EQ(k.ruling, Ruling::none);
  }
}

TEST(Decisions, RetractTakesAPublishedOneOutAndUndoBringsItBack) {
  DecisionBook book;
  Alignment k = alignment(AlignmentState::verified);
  k.state = AlignmentState::published;
  ASSERT_TRUE(decide(book, k, Decision::retract));
  EXPECT_EQ(k.state, AlignmentState::retracted);
  EXPECT_EQ(book.proposal(k.id, k.T_a_b, 5000), Proposal::suppressed);
  ASSERT_TRUE(decide(book, k, Decision::undo));
  EXPECT_EQ(k.state, AlignmentState::published);
  EXPECT_EQ(book.proposal(k.id, k.T_a_b, 5000), Proposal::open);
}

TEST(Decisions, UndoGoesBackOneDecisionAtATime) {
  DecisionBook book;
  Alignment k = alignment();
  ASSERT_TRUE(decide(book, k, Decision::refuse));
  ASSERT_TRUE(decide(book, k, Decision::confirm));
  ASSERT_TRUE(decide(book, k, Decision::retract));
  EXPECT_EQ(k.state, AlignmentState::retracted);
  ASSERT_TRUE(decide(book, k, Decision::undo));
  EXPECT_EQ(k.state, AlignmentState::published);
  ASSERT_TRUE(decide(book, k, Decision::undo));
  EXPECT_EQ(k.ruling, Ruling::refused);
  EXPECT_EQ(k.state, AlignmentState::rejected);
  ASSERT_TRUE(decide(book, k, Decision::undo));
  EXPECT_EQ(k.state, AlignmentState::candidate);
  const auto none = book.decide(k, Decision::undo);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "alignment 7 has no decision to undo");
}

TEST(Decisions, WhatDoesNotFitIsRefusedWithWhatToDoInstead) {
  DecisionBook book;
  Alignment candidate = alignment(), published = alignment(AlignmentState::verified), empty = alignment();
  published.state = AlignmentState::published;
  empty.evidence.inlier_fraction = 0;
  const auto message = [&](const Alignment& k, Decision decision) {
    const auto record = book.decide(k, decision);
    return record ? "allowed" : record.error().message;
  };
  EXPECT_EQ(message(candidate, Decision::retract), "alignment 7 is not published but candidate; refuse it instead");
  EXPECT_EQ(message(published, Decision::refuse), "alignment 7 is published; retract it instead");
  EXPECT_EQ(message(empty, Decision::confirm), "alignment 7 has no placement to decide on: nothing fitted");
  EXPECT_TRUE(book.records().empty());
}

TEST(Decisions, ARefusalSpeaksOfItsPlacementAlone) {
  DecisionBook book;
  Alignment k = alignment();
  ASSERT_TRUE(decide(book, k, Decision::refuse));
  for (const auto& [metres, degrees, proposal] :
       {std::tuple{1.9, 0.0, Proposal::suppressed}, std::tuple{2.1, 0.0, Proposal::open},
        std::tuple{0.0, 9.5, Proposal::suppressed}, std::tuple{0.0, 10.5, Proposal::open}})
    EXPECT_EQ(book.proposal(k.id, moved(k.T_a_b, metres, degrees), 5000), proposal) << metres << " " << degrees;
  EXPECT_EQ(book.proposal(k.id + 1, k.T_a_b, 5000), Proposal::open) << "of another pair";
  k.T_a_b = moved(k.T_a_b, 20, 0);
  EXPECT_EQ(book.ruling(k), Ruling::none);
}

TEST(Decisions, MuchMoreEvidenceShowsARefusedPlacementAgainButNeverPublishesIt) {
  DecisionBook book;
  Alignment k = alignment();
  ASSERT_TRUE(decide(book, k, Decision::refuse));
  EXPECT_EQ(book.proposal(k.id, k.T_a_b, 9999), Proposal::suppressed);
  EXPECT_EQ(book.proposal(k.id, k.T_a_b, 10000), Proposal::as_candidate);
  Alignment thin = alignment();
  thin.id = 8;
  thin.evidence.seen_points = 10;
  ASSERT_TRUE(decide(book, thin, Decision::refuse));
  EXPECT_EQ(book.proposal(thin.id, thin.T_a_b, 2009), Proposal::suppressed) << "twice of nothing is nothing";
  EXPECT_EQ(book.proposal(thin.id, thin.T_a_b, 2010), Proposal::as_candidate);
}

TEST(Decisions, AConfirmationDoesNotReachPlacementsThatCameAfterItsRetraction) {
  DecisionBook book;
  Alignment k = alignment();
  ASSERT_TRUE(decide(book, k, Decision::confirm));
  const Pose T_confirmed = k.T_a_b;
  ASSERT_TRUE(decide(book, k, Decision::retract));
  k.T_a_b = moved(k.T_a_b, 20, 0);  // later evidence proposes another
  EXPECT_EQ(book.ruling(k), Ruling::none);
  EXPECT_FALSE(book.confirmed_at(k.id));
  ASSERT_TRUE(decide(book, k, Decision::undo));
  ASSERT_TRUE(book.confirmed_at(k.id));
  EXPECT_TRUE(book.confirmed_at(k.id)->isApprox(T_confirmed));
}

TEST(Decisions, WhatWasPlacedByHandWaitsForAConfirmationWhateverWasSaidOfItBefore) {
  DecisionBook book;
  Alignment k = alignment();
  ASSERT_TRUE(decide(book, k, Decision::refuse));
  EXPECT_EQ(book.place(k).decision, Decision::place);
  k.ruling = book.ruling(k);
  EXPECT_EQ(k.ruling, Ruling::placed);
  EXPECT_EQ(decided_state(k), AlignmentState::candidate);
  EXPECT_EQ(book.proposal(k.id, k.T_a_b, 5000), Proposal::open);
  EXPECT_EQ(book.ruling([&] {
    Alignment far = k;
    far.T_a_b = moved(k.T_a_b, 2.1, 0);
    return far;
  }()),
            Ruling::none);
  EXPECT_FALSE(book.decide(k, Decision::place)) << "not by its number";
  ASSERT_TRUE(decide(book, k, Decision::confirm));
  EXPECT_EQ(k.state, AlignmentState::published);
  ASSERT_TRUE(decide(book, k, Decision::undo));
  EXPECT_EQ(k.ruling, Ruling::placed);
  ASSERT_TRUE(decide(book, k, Decision::undo));
  EXPECT_EQ(k.ruling, Ruling::refused);
}

TEST(Decisions, SurviveBeingStored) {
  DecisionBook book;
  Alignment k = alignment();
  ASSERT_TRUE(decide(book, k, Decision::refuse));
  ASSERT_TRUE(decide(book, k, Decision::confirm));
  ASSERT_TRUE(decide(book, k, Decision::undo));
  DecisionBook later;
  later.restore(book.records());
  EXPECT_EQ(later.ruling(k), Ruling::refused);
  const auto next = later.decide(k, Decision::confirm);
  ASSERT_TRUE(next && *next);
  EXPECT_EQ((*next)->id, 3);
}

TEST(Decisions, NamesGoBothWays) {
  for (const auto d : {Decision::confirm, Decision::refuse, Decision::retract, Decision::undo, Decision::place})
    EXPECT_EQ(decision_from(to_string(d)), d);
  EXPECT_FALSE(decision_from("maybe"));
}

}  // namespace
}  // namespace headframe
