#include "server/atlas/dependents.hpp"

#include <gtest/gtest.h>

namespace headframe {
namespace {

//   1 --- 2 --- 3      6 (alone)
//         |     |
//         4 --- 5
Atlas atlas() {
  Atlas out;
  out.components = {{1, {{1}, {2}, {3}, {4}, {5}}}, {6, {{6}}}};
  return out;
}

Alignment edge(SessionId a, SessionId b, AlignmentState state = AlignmentState::published) {
  Alignment k;
  k.a = a, k.b = b, k.state = state;
  return k;
}

const std::vector<Alignment> edges{edge(1, 2), edge(2, 3), edge(2, 4), edge(4, 5), edge(3, 5)};
using Parts = std::vector<std::vector<SessionId>>;

TEST(Dependents, AreWhoIsMergedWithItAndWhatComesApart) {
  const Dependents of_2 = dependents_of(2, atlas(), edges);
  EXPECT_EQ(of_2.merged_with, (std::vector<SessionId>{1, 3, 4}));
  EXPECT_FALSE(of_2.is_anchor);
  EXPECT_EQ(of_2.parts, (Parts{{1}, {3, 4, 5}}));
  const Dependents of_1 = dependents_of(1, atlas(), edges);
  EXPECT_TRUE(of_1.is_anchor);
  EXPECT_EQ(of_1.parts, (Parts{{2, 3, 4, 5}}));
  EXPECT_EQ(dependents_of(5, atlas(), edges).parts, (Parts{{1, 2, 3, 4}}));
}

TEST(Dependents, WhatIsNotPublishedHoldsNothing) {
  std::vector<Alignment> weak = edges;
  weak[4].state = AlignmentState::verified;
  EXPECT_EQ(dependents_of(4, atlas(), weak).parts, (Parts{{1, 2, 3}, {5}}));
  EXPECT_EQ(dependents_of(4, atlas(), weak).merged_with, (std::vector<SessionId>{2, 5}));
}

TEST(Dependents, OfOneAloneOrUnknownThereAreNone) {
  for (const SessionId id : {6, 7}) {
    const Dependents none = dependents_of(id, atlas(), edges);
    EXPECT_TRUE(none.merged_with.empty() && none.parts.empty() && !none.is_anchor) << id;
  }
}

}  // namespace
}  // namespace headframe
