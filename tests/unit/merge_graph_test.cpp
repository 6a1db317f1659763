#include "server/atlas/merge_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace headframe {
namespace {

// The mine of these tests:   1 --- 2 --- 3
//                                  |     |
//                                  4 --- 5      6 (alone)
const std::vector<SessionId> sessions{1, 2, 3, 4, 5, 6};

Pose true_pose(SessionId s) {
  const auto x = static_cast<double>(s);
  return pose_from_yaw(0.7 * x, {20 * x, -7 * x * x, 0.5 * x});
}

Alignment edge(SessionId a, SessionId b, double probability = 0.95, const Pose& error = Pose::Identity()) {
  Alignment k;
  k.id = 10 * a + b;
  k.a = a;
  k.b = b;
  k.state = AlignmentState::verified;
  k.T_a_b = true_pose(a).inverse() * true_pose(b) * error;
  k.evidence.probability = probability;
  return k;
}

std::vector<Alignment> loop() { return {edge(1, 2), edge(2, 3), edge(2, 4), edge(4, 5), edge(3, 5)}; }

double worst_error_m(const MergeResult& result) {
  double worst = 0;
  for (const Component& c : result.components)
    for (const Placement& p : c.placements) {
      const Pose truth = true_pose(c.id).inverse() * true_pose(p.session);
      worst = std::max(worst, (truth.inverse() * p.T_component_session).translation().norm());
    }
  return worst;
}

TEST(MergeGraph, ComponentsFollowTheAlignments) {
  const auto result = merge_sessions(sessions, loop());
  ASSERT_EQ(result.components.size(), 2U);
  EXPECT_EQ(result.components[0].id, 1);
  EXPECT_EQ(result.components[0].placements.size(), 5U);
  EXPECT_EQ(result.components[1].id, 6);
  EXPECT_TRUE(result.components[0].placements[0].T_component_session.isApprox(Pose::Identity()));
  EXPECT_LT(worst_error_m(result), 1e-9);
  for (const auto state : result.states) EXPECT_EQ(state, AlignmentState::published);
}

const Pose& placed_at(const MergeResult& result, SessionId session) {
  for (const Component& c : result.components)
    if (const Placement* p = placement_in(c, session)) return p->T_component_session;
  throw std::out_of_range("no such session");
}

TEST(MergeGraph, AFrozenSessionIsTheAnchorWhateverWasChosen) {
  const auto anchor = [](const FrozenSessions& frozen, const std::vector<SessionId>& anchors) {
    return merge_sessions(sessions, loop(), {}, anchors, {}, frozen).components.at(0).id;
  };
  const FrozenSession three{3, 3}, five{5, 5};
  EXPECT_EQ(anchor({}, {2}), 2);
  EXPECT_EQ(anchor({{3, three}}, {2}), 3);
  EXPECT_EQ(anchor({{3, three}, {5, five}}, {2}), 3) << "the earliest";
  EXPECT_EQ(anchor({{3, three}, {5, five}}, {3, 5, 2}), 5) << "the one that was chosen last";
  EXPECT_EQ(anchor({{6, {6, 6}}}, {2}), 2) << "it is of another component";
}

TEST(MergeGraph, SessionsFrozenInOneFrameKeepTheirPlacesAndTheOthersAlignToThem) {
  const Pose off = pose_from_yaw(0.02, {0.8, -0.5, 0.1});
  const std::vector<Alignment> wrong{edge(1, 2), edge(2, 3, 0.95, off), edge(2, 4), edge(4, 5), edge(3, 5, 0.95, off)};
  const Pose T_2_5 = true_pose(2).inverse() * true_pose(5) * pose_from_yaw(-0.01, {0.3, 0.2, 0});
  // Frozen in the frame of a session that is not even here.
  const Pose T_9_2 = pose_from_yaw(1, {7, 8, 9});
  const FrozenSessions frozen{{2, {2, 9, T_9_2}}, {5, {5, 9, T_9_2 * T_2_5}}};
  for (const auto& edges : {wrong, {edge(1, 2), edge(2, 4), edge(4, 5)}, {wrong[0], wrong[1], wrong[4]}}) {
    const auto result = merge_sessions(sessions, edges, {}, {}, {}, frozen);
    ASSERT_EQ(result.components.at(0).id, 2);
    EXPECT_TRUE(placed_at(result, 5).isApprox(T_2_5, 1e-9)) << "whatever else there is";
    EXPECT_TRUE(placed_at(result, 2).isApprox(Pose::Identity(), 0));
  }
  const auto between = merge_sessions(sessions, wrong, {}, {}, {}, frozen);
  const Pose free_4 = placed_at(merge_sessions(sessions, wrong, {}, std::vector<SessionId>{2}), 4);
  EXPECT_GT((placed_at(between, 4).translation() - free_4.translation()).norm(), 0.01) << "it gives way to them";
  const auto alone = merge_sessions(sessions, wrong, {}, {}, {}, {{2, frozen.at(2)}, {5, {5, 5}}});
  EXPECT_GT((placed_at(alone, 5).translation() - T_2_5.translation()).norm(), 0.01) << "in frames of their own";
}

TEST(MergeGraph, TheAnchorChosenLastIsTheComponentsFrame) {
  const auto anchored = [](const std::vector<Alignment>& edges, const std::vector<SessionId>& anchors) {
    return merge_sessions(sessions, edges, {}, anchors);
  };
  for (const SessionId chosen : {1, 3, 5}) {
    const auto result = anchored(loop(), {4, chosen, 6});
    ASSERT_EQ(result.components.size(), 2U);
    EXPECT_EQ(result.components[0].id, chosen);
    EXPECT_EQ(result.components[1].id, 6);
    EXPECT_LT(worst_error_m(result), 1e-9) << "all others lie as before, seen from it";
    for (const Placement& p : result.components[0].placements)
      EXPECT_EQ(p.T_component_session.matrix() == Pose::Identity().matrix(), p.session == chosen);
  }
  // 1-2 and 4-5 apart, each with its choice; when they merge, the later choice stays.
  const std::vector<Alignment> apart{edge(1, 2), edge(4, 5)}, joined{edge(1, 2), edge(4, 5), edge(2, 4)};
  EXPECT_EQ(anchored(apart, {5, 2}).components[0].id, 2);
  EXPECT_EQ(anchored(apart, {5, 2}).components.back().id, 6);
  EXPECT_EQ(anchored(joined, {5, 2}).components[0].id, 2);
  EXPECT_EQ(anchored(joined, {2, 5}).components[1].id, 5) << "sorted by id, after 3";
  EXPECT_EQ(anchored(joined, {7}).components[0].id, 1) << "a choice elsewhere means nothing here";
}

TEST(MergeGraph, OrderOfArrivalDoesNotMatter) {
  auto edges = loop();
  edges[2].T_a_b.translation().x() += 0.3;
  const auto first = merge_sessions(sessions, edges);
  std::mt19937 rng(1);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(edges.begin(), edges.end(), rng);
    const auto again = merge_sessions(sessions, edges);
    ASSERT_EQ(again.components.size(), first.components.size());
    for (std::size_t c = 0; c < first.components.size(); ++c)
      for (std::size_t p = 0; p < first.components[c].placements.size(); ++p)
        EXPECT_LT((again.components[c].placements[p].T_component_session.translation() -
                   first.components[c].placements[p].T_component_session.translation())
                      .norm(),
                  1e-6);
  }
}

TEST(MergeGraph, ALoopSpreadsASmallErrorOverItsEdges) {
  auto edges = loop();
  edges[4].T_a_b.translation().x() += 0.4;
  const auto result = merge_sessions(sessions, edges);
  EXPECT_LT(worst_error_m(result), 0.25);
  EXPECT_GT(worst_error_m(result), 0.05);
}

TEST(MergeGraph, AnAlignmentThatContradictsALoopIsHeldBackAndAPublishedOneRetracted) {
  const Pose wrong = pose_from_yaw(0, {6, 0, 0});
  for (const auto before : {AlignmentState::verified, AlignmentState::published}) {
    auto edges = loop();
    edges[4] = edge(3, 5, 0.91, wrong);
    edges[4].state = before;
    const auto result = merge_sessions(sessions, edges);
    EXPECT_LT(worst_error_m(result), 1e-9);
    EXPECT_EQ(result.states[4],
              before == AlignmentState::published ? AlignmentState::retracted : AlignmentState::verified);
  }
}

TEST(MergeGraph, ALaterLoopTakesAPublishedMergeOutHoweverSureItLooked) {
  // 1-2 is wrong and was published first. The loop over 3 can not tell which of three is wrong; the one over 4 can.
  auto wrong = edge(1, 2, 0.99, pose_from_yaw(0, {6, 0, 0}));
  wrong.state = AlignmentState::published;
  std::vector<Alignment> edges{wrong, edge(1, 3, 0.92), edge(2, 3, 0.91)};
  auto result = merge_sessions(sessions, edges);
  EXPECT_EQ(result.states[0], AlignmentState::published);
  EXPECT_EQ(result.states[2], AlignmentState::verified) << "the least probable of the three is held back";
  edges.push_back(edge(1, 4, 0.92));
  edges.push_back(edge(2, 4, 0.91));
  result = merge_sessions(sessions, edges);
  EXPECT_EQ(result.states[0], AlignmentState::retracted);
  for (std::size_t i = 1; i < edges.size(); ++i) EXPECT_EQ(result.states[i], AlignmentState::published) << i;
  EXPECT_LT(worst_error_m(result), 1e-9);
}

TEST(MergeGraph, AConfirmedAlignmentIsTheStrongestAndWaitsForAnotherConfirmedOne) {
  const Pose wrong = pose_from_yaw(0, {6, 0, 0});
  auto edges = loop();
  edges[4] = edge(3, 5, 0.1, wrong);
  edges[4].ruling = Ruling::confirmed;
  edges[3].evidence.probability = 0.91;
  edges[3].state = AlignmentState::published;
  auto result = merge_sessions(sessions, edges);
  EXPECT_EQ(result.states[4], AlignmentState::published);
  EXPECT_EQ(result.states[3], AlignmentState::retracted) << "the weakest of the loop";
  for (auto& e : edges) e.ruling = Ruling::confirmed;
  edges[4].state = AlignmentState::published;
  result = merge_sessions(sessions, edges);
  EXPECT_EQ(result.states[4], AlignmentState::verified) << "confirmed ones wait";
  edges[0].state = AlignmentState::retracted;
  edges[1].state = AlignmentState::retracted;
  EXPECT_EQ(merge_sessions(sessions, edges).states[4], AlignmentState::published) << "nothing contradicts it any more";
}

/// Answers for one pair, and remembers who was asked about.
struct Asked {
  std::pair<SessionId, SessionId> pair;
  Contact answer;
  std::vector<std::pair<SessionId, SessionId>> others;

  MergeResult merge(const std::vector<Alignment>& edges) {
    return merge_sessions(sessions, edges, {}, {}, [this](SessionId a, SessionId b, const Pose& T_a_b) {
      EXPECT_LT(a, b);
      EXPECT_TRUE(T_a_b.isApprox(true_pose(a).inverse() * true_pose(b), 1e-9)) << a << " " << b;
      others.emplace_back(a, b);
      return std::pair(a, b) == pair ? answer : Contact::none;
    });
  }
};

TEST(MergeGraph, OnlySessionsThatAMergeWouldBringTogetherAreAsked) {
  Asked none{{0, 0}, Contact::none, {}};
  const auto result = none.merge(loop());
  EXPECT_EQ(result.components.size(), 2U);
  std::sort(none.others.begin(), none.others.end());
  const std::vector<std::pair<SessionId, SessionId>> without_alignment{{1, 3}, {1, 4}, {1, 5}, {2, 5}, {3, 4}};
  EXPECT_EQ(none.others, without_alignment) << "each once; 6 meets nobody";
}

TEST(MergeGraph, AMergeThatTwoOtherSessionsContradictIsHeldBack) {
  // 1-2-3 hold together; 3-5 is the weakest, and what 5 saw passes through what 1 saw.
  for (const auto before : {AlignmentState::verified, AlignmentState::published}) {
    std::vector<Alignment> edges{edge(1, 2, 0.99), edge(2, 3, 0.98), edge(3, 5, 0.91)};
    edges[2].state = before;
    for (const Contact answer : {Contact::none, Contact::agrees, Contact::contradicts}) {
      const auto result = Asked{{1, 5}, answer, {}}.merge(edges);
      const bool held = answer == Contact::contradicts;
      EXPECT_EQ(result.components.size(), held ? 4U : 3U);
      EXPECT_EQ(result.contradicted_by[2].has_value(), held);
      if (held) {
        EXPECT_EQ(result.contradicted_by[2], (std::pair<SessionId, SessionId>(1, 5)));
      }
      const auto kept_back = before == AlignmentState::published ? AlignmentState::retracted : AlignmentState::verified;
      EXPECT_EQ(result.states[2], held ? kept_back : AlignmentState::published);
      EXPECT_EQ(result.states[0], AlignmentState::published);
    }
    edges[2].ruling = Ruling::confirmed;
    EXPECT_EQ((Asked{{1, 5}, Contact::contradicts, {}}.merge(edges).states[2]), AlignmentState::published)
        << "the operator knows better";
  }
}

TEST(MergeGraph, OfTwoThatCanNotBothBeRightTheSurerStands) {
  // What 1 saw contradicts what 5 saw, so of 1-3 and 3-5 one is wrong.
  const auto stands = [](const Evidence& first, const Evidence& second) {
    std::vector<Alignment> edges{edge(1, 3), edge(3, 5)};
    edges[0].evidence = first;
    edges[1].evidence = second;
    const auto states = Asked{{1, 5}, Contact::contradicts, {}}.merge(edges).states;
    EXPECT_NE(states[0] == AlignmentState::published, states[1] == AlignmentState::published);
    return states[0] == AlignmentState::published ? 1 : 2;
  };
  Evidence sure, less, rivalled, of_copies;
  sure.probability = 0.99;
  less.probability = 0.98;
  rivalled = of_copies = sure;
  rivalled.runner_up = 0.02;
  of_copies.probability = 0.95;
  of_copies.probability_if_unique = 0.999;
  EXPECT_EQ(stands(sure, less), 1);
  EXPECT_EQ(stands(less, sure), 2);
  EXPECT_EQ(stands(rivalled, sure), 2) << "the first has a rival";
  EXPECT_EQ(stands(of_copies, sure), 1) << "aliases are left aside";
}

/// What became of 1-2, 2-3 and 3-5 when what 1 saw contradicts what 5 saw.
std::vector<AlignmentState> states_of(const std::vector<double>& overlaps_m, double repetition,
                                      Ruling of_the_second = Ruling::none) {
  std::vector<Alignment> edges{edge(1, 2, 0.99), edge(2, 3, 0.98), edge(3, 5, 0.91)};
  for (std::size_t i = 0; i < edges.size(); ++i) edges[i].evidence.overlap_m = overlaps_m[i];
  edges[0].evidence.repetition = repetition;
  edges[1].ruling = of_the_second;
  return Asked{{1, 5}, Contact::contradicts, {}}.merge(edges).states;
}

TEST(MergeGraph, NeitherOfTwoThatCanNotBothBeRightIsBelieved) {
  constexpr auto waits = AlignmentState::verified, stands = AlignmentState::published;
  using States = std::vector<AlignmentState>;
  EXPECT_EQ(states_of({30, 30, 30}, 0), (States{waits, waits, waits})) << "that both fit shows a copy";
  EXPECT_EQ(states_of({30, 30, 30}, 0.15), (States{waits, waits, waits}));
  EXPECT_EQ(states_of({44, 44, 30}, 0.15), (States{waits, waits, waits}));
  EXPECT_EQ(states_of({45, 45, 30}, 0.15), (States{stands, stands, waits})) << "clearly longer than the copy may be";
  EXPECT_EQ(states_of({45, 30, 30}, 0.15), (States{stands, waits, waits}));
  EXPECT_EQ(states_of({45, 30, 45}, 0.15), (States{waits, waits, waits}));
  EXPECT_EQ(states_of({45, 29, 45}, 0.15), (States{waits, waits, waits})) << "1-2 is no longer than 3-5";
  EXPECT_EQ(states_of({100, 20, 45}, 0.15), (States{stands, waits, stands})) << "the short one was the copy";
  EXPECT_EQ(states_of({30, 30, 30}, 0.15, Ruling::confirmed), (States{waits, stands, waits}));
}

TEST(MergeGraph, OneInDoubtThatWasPublishedGoesOnContradicting) {
  std::vector<Alignment> edges{edge(1, 3, 0.99), edge(3, 5, 0.98)};
  for (Alignment& k : edges) k.evidence.overlap_m = 30, k.evidence.repetition = 1;
  edges[0].state = AlignmentState::published;
  for (int update = 0; update < 3; ++update) {
    const auto result = Asked{{1, 5}, Contact::contradicts, {}}.merge(edges);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      EXPECT_EQ(result.states[i], AlignmentState::verified) << update;
      EXPECT_EQ(result.contradicted_by[i], (std::pair<SessionId, SessionId>(1, 5))) << update;
      edges[i].state = result.states[i];
    }
  }
}

TEST(MergeGraph, WhileNobodyHasLookedWhatIsPublishedStaysAndWhatIsNotWaits) {
  std::vector<Alignment> edges{edge(1, 2, 0.99), edge(2, 3, 0.98)};
  EXPECT_EQ((Asked{{1, 3}, Contact::unknown, {}}.merge(edges).states[1]), AlignmentState::verified);
  edges[1].state = AlignmentState::published;
  const auto result = Asked{{1, 3}, Contact::unknown, {}}.merge(edges);
  EXPECT_EQ(result.states[1], AlignmentState::published);
  EXPECT_FALSE(result.contradicted_by[1]);
}

TEST(MergeGraph, ToleranceHasTwoSides) {
  const LoopTolerance tolerance;
  const double reach = tolerance.translation_m + 0.01 * (true_pose(3).inverse() * true_pose(5)).translation().norm();
  for (const auto& [error_m, agrees] : {std::pair{0.98 * reach, true}, std::pair{1.05 * reach, false}}) {
    auto edges = loop();
    edges[4] = edge(3, 5, 0.91, pose_from_yaw(0, {error_m, 0, 0}));
    EXPECT_EQ(merge_sessions(sessions, edges).states[4] == AlignmentState::published, agrees) << error_m;
  }
}

TEST(MergeGraph, OnlyVerifiedAlignmentsCount) {
  for (const auto state : {AlignmentState::candidate, AlignmentState::rejected, AlignmentState::retracted}) {
    auto edges = loop();
    for (auto& e : edges) e.state = state;
    const auto result = merge_sessions(sessions, edges);
    EXPECT_EQ(result.components.size(), sessions.size());
    EXPECT_EQ(result.states[0], state);
  }
}

TEST(Evidence, EveryFieldHasAName) {
  Evidence e;
  for (const auto& field : evidence_fields()) e.*field.member = 1;
  EXPECT_EQ(evidence_fields().size() * sizeof(double), sizeof(Evidence));
  for (const auto state : {AlignmentState::candidate, AlignmentState::verified, AlignmentState::published,
                           AlignmentState::retracted, AlignmentState::rejected})
    EXPECT_EQ(alignment_state_from(to_string(state)), state);
  EXPECT_FALSE(alignment_state_from("nonsense"));
}

}  // namespace
}  // namespace headframe
