#pragma once

#include "tests/bench/driven_session.hpp"

namespace headframe::bench {

/// Rank, from 1, of the first right hypothesis (within 4 m near the overlap and 20 deg) among those that are handed on
/// to registration for two sessions of one family; 0: none is right.
std::size_t rank_of_right_hypothesis(const DrivenSession& a, const DrivenSession& b);

}  // namespace headframe::bench
