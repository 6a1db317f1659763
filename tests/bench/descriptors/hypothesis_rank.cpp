#include "tests/bench/descriptors/hypothesis_rank.hpp"

#include "server/merge/session_map.hpp"
#include "server/place/hypotheses.hpp"
#include "tests/support/truth.hpp"

namespace headframe::bench {
namespace {

constexpr double near_m = 4, near_deg = 20;

/// The session's keyframes as the merge pipeline keeps them.
std::vector<Keyframe> kept(const DrivenSession& driven) {
  Session session;
  session.keyframes = driven.keyframes;
  session.complete = true;
  session.set_aside_outliers();
  return std::move(session.keyframes);
}

}  // namespace

std::size_t rank_of_right_hypothesis(const DrivenSession& a, const DrivenSession& b) {
  const MergeConfig config;
  const std::vector<Keyframe> of_a = kept(a), of_b = kept(b);
  HypothesisFinder finder(
      {.seats = {.coherent = static_cast<std::size_t>(config.hypotheses)}, .threads = config.threads});
  const Found* found = finder.find({1, of_a}, {2, of_b});
  for (std::size_t i = 0; i < found->hypotheses.size(); ++i) {
    const auto error = test::overlap_error(a.path, b.path, found->hypotheses[i].T_a_b);
    if (error.pairs > 0 && error.translation_m < near_m && error.rotation_deg < near_deg) return i + 1;
  }
  return 0;
}

}  // namespace headframe::bench
