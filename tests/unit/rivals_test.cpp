#include "server/atlas/rivals.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>

namespace headframe {
namespace {

constexpr double look_alikes = 1.5;

Pose true_pose(SessionId s) {
  const auto x = static_cast<double>(s);
  return pose_from_yaw(0.7 * x, {20 * x, -7 * x * x, 0.5 * x});
}

Alignment edge(SessionId one, SessionId other, AlignmentState state, double probability) {
  const auto [a, b] = std::minmax(one, other);
  Alignment k;
  k.a = a;
  k.b = b;
  k.state = state;
  k.T_a_b = true_pose(a).inverse() * true_pose(b);
  k.evidence.probability = probability;
  k.evidence.inlier_fraction = 0.8;
  k.evidence.overlap_m = 40;
  k.evidence.similar_places = 2;
  return k;
}

Alignment accepted(SessionId one, SessionId other) { return edge(one, other, AlignmentState::verified, 0.95); }
Alignment candidate(SessionId one, SessionId other) { return edge(one, other, AlignmentState::candidate, 0.8); }

Contacts all_say(Contact contact) {
  return [contact](SessionId, SessionId, const Pose&) { return contact; };
}

Doubts doubts(const std::vector<Alignment>& alignments, Contact contact = Contact::contradicts) {
  return rivalled(alignments, {}, look_alikes, {1, 2, 3}, all_say(contact));
}

TEST(Rivals, OneThatCannotBeRightTogetherWithACandidateIsInDoubt) {
  const std::vector<Alignment> both{accepted(1, 2), candidate(2, 3)};
  EXPECT_EQ(doubts(both), (Doubts{{0, std::pair<SessionId, SessionId>(1, 3)}}));
  EXPECT_TRUE(doubts(both, Contact::none).empty());
  EXPECT_TRUE(doubts(both, Contact::agrees).empty());
  EXPECT_EQ(doubts(both, Contact::unknown), (Doubts{{0, std::nullopt}})) << "until they are compared";
  EXPECT_TRUE(rivalled(both, {}, look_alikes, {1, 2, 3}, {}).empty()) << "nobody can be asked";
}

TEST(Rivals, APublishedOneStaysUntilThereIsAContradiction) {
  std::vector<Alignment> both{accepted(1, 2), candidate(2, 3)};
  both[0].state = AlignmentState::published;
  EXPECT_TRUE(doubts(both, Contact::unknown).empty());
  EXPECT_EQ(doubts(both).size(), 1U);
}

TEST(Rivals, TheOtherTwoSessionsAreAskedWhereBothAlignmentsBringThem) {
  std::array<SessionId, 3> ids{1, 2, 3};
  do {
    const auto [one, shared, other] = ids;
    int asked = 0;
    const Contacts contacts = [&, one = one, other = other](SessionId a, SessionId b, const Pose& T_a_b) {
      ++asked;
      EXPECT_EQ(a, std::min(one, other));
      EXPECT_EQ(b, std::max(one, other));
      EXPECT_TRUE(T_a_b.isApprox(true_pose(a).inverse() * true_pose(b), 1e-9));
      return Contact::contradicts;
    };
    const std::vector<Alignment> both{accepted(one, shared), candidate(shared, other)};
    EXPECT_EQ(rivalled(both, {}, look_alikes, {1, 2, 3}, contacts).size(), 1U);
    EXPECT_EQ(asked, 1);
  } while (std::next_permutation(ids.begin(), ids.end()));
}

/// Whether 1-2 is in doubt after the change to it or to the candidate 2-3.
bool in_doubt_after(const std::function<void(Alignment& k, Alignment& candidate)>& change) {
  std::vector<Alignment> both{accepted(1, 2), candidate(2, 3)};
  change(both[0], both[1]);
  return doubts(both).contains(0);
}

TEST(Rivals, OnlyWherePlacesLookAlike) {
  EXPECT_TRUE(in_doubt_after([](Alignment& k, Alignment&) { k.evidence.similar_places = look_alikes; }));
  EXPECT_FALSE(in_doubt_after([](Alignment& k, Alignment&) { k.evidence.similar_places = look_alikes - 0.01; }));
}

TEST(Rivals, AWeakOrShortCandidateIsNone) {
  const double tenth = 1.9 / 2.9;  // a tenth of the odds of .95
  EXPECT_TRUE(in_doubt_after([&](Alignment&, Alignment& c) { c.evidence.probability = tenth + 0.001; }));
  EXPECT_FALSE(in_doubt_after([&](Alignment&, Alignment& c) { c.evidence.probability = tenth - 0.001; }));
  VerdictThresholds stricter;
  stricter.runner_up_share = 0.3;
  EXPECT_TRUE(rivalled(std::vector{accepted(1, 2), candidate(2, 3)}, stricter, look_alikes, {1, 2, 3},
                       all_say(Contact::contradicts))
                  .empty())
      << "it has a fifth of the odds";
  EXPECT_TRUE(in_doubt_after([](Alignment& k, Alignment&) { k.evidence.overlap_m = 59; }));
  EXPECT_FALSE(in_doubt_after([](Alignment& k, Alignment&) { k.evidence.overlap_m = 60; })) << "clearly longer";
  EXPECT_FALSE(in_doubt_after([](Alignment&, Alignment& c) { c.evidence.inlier_fraction = 0; })) << "no placement";
}

TEST(Rivals, WhatTheOperatorDecidedOrWhatDoesNotMergeIsLeftAlone) {
  EXPECT_FALSE(in_doubt_after([](Alignment& k, Alignment&) { k.ruling = Ruling::confirmed; }));
  EXPECT_FALSE(in_doubt_after([](Alignment&, Alignment& c) { c.ruling = Ruling::refused; }));
  EXPECT_FALSE(in_doubt_after([](Alignment& k, Alignment&) { k.state = AlignmentState::candidate; }));
  EXPECT_FALSE(in_doubt_after([](Alignment&, Alignment& c) { c.state = AlignmentState::rejected; }));
  EXPECT_FALSE(in_doubt_after([](Alignment&, Alignment& c) { c.state = AlignmentState::published; }))
      << "merging settles that";
  EXPECT_FALSE(in_doubt_after([](Alignment&, Alignment& c) { c = candidate(3, 4); })) << "shares no session";
}

TEST(Rivals, ACandidateOfASessionThatIsSetAsideHasNoSay) {
  const std::vector<Alignment> both{accepted(1, 2), candidate(2, 3)};
  EXPECT_TRUE(rivalled(both, {}, look_alikes, {1, 2}, all_say(Contact::contradicts)).empty());
}

TEST(Rivals, OneInDoubtWaitsButALoopOfOthersProvesIt) {
  const std::vector<SessionId> sessions{1, 2, 3, 4};
  const auto result_of = [&](const std::vector<Alignment>& alignments, const Doubts& doubts) {
    return merge_sessions(sessions, alignments, {}, {}, all_say(Contact::none), {}, {}, doubts);
  };
  const Doubts by_candidate{{0, std::pair<SessionId, SessionId>(1, 3)}}, not_compared{{0, std::nullopt}};
  std::vector<Alignment> alignments{accepted(1, 2)};
  for (const Doubts& doubts : {by_candidate, not_compared}) {
    const MergeResult waits = result_of(alignments, doubts);
    EXPECT_EQ(waits.states[0], AlignmentState::verified);
    EXPECT_EQ(waits.contradicted_by[0], doubts.at(0));
    EXPECT_EQ(waits.components.size(), 4U);
  }
  alignments.push_back(accepted(2, 4));
  alignments.push_back(accepted(1, 4));
  EXPECT_EQ(result_of(alignments, by_candidate).states[0], AlignmentState::published);
}

}  // namespace
}  // namespace headframe
