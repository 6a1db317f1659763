// A robot that still drives has not shown what lies ahead of it: an exact copy of a tile looks right until the tile
// ends. What convinces waits until both sessions have shown enough, and what was decided on half a session is decided
// anew when it ends.

#include <algorithm>

#include "server/merge_state.hpp"

namespace headframe {
namespace {

/// Path that the session came along after it last was within reach_m of the other's; nothing: it never was.
std::optional<double> path_since(const Session& session, const Session& other, const Pose& T_other_session,
                                 double reach_m) {
  for (std::size_t i = session.keyframes.size(); i-- > 0;) {
    const Eigen::Vector3d p = T_other_session * session.keyframes[i].T_local_sensor.translation();
    const bool reached = std::any_of(other.keyframes.begin(), other.keyframes.end(), [&](const Keyframe& k) {
      return (k.T_local_sensor.translation() - p).squaredNorm() < reach_m * reach_m;
    });
    if (reached) return session.path_m() - session.path_to_m[i];
  }
  return std::nullopt;
}

}  // namespace

double MergePipeline::State::path_awaited_m(const Laid& pair, const Pose& T_a_b, double shared_m) const {
  const Session &a = sessions.at(pair.a), &b = sessions.at(pair.b);
  const double reach_m = JudgeConfig{}.meet_m;
  double awaited_m = 0;
  const auto wait_for = [&](const Session& session, const Session& other, const Pose& T_other_session) {
    if (session.complete) return;
    const double since_m = path_since(session, other, T_other_session, reach_m).value_or(0);
    awaited_m = std::max(awaited_m, config.shown_m - shared_m - since_m);
  };
  wait_for(a, b, T_a_b.inverse());
  wait_for(b, a, T_a_b);
  return awaited_m;
}

bool MergePipeline::State::ended_since_judged(const Alignment& known) const {
  const Session &a = sessions.at(known.a), &b = sessions.at(known.b);
  return a.complete && b.complete && a.path_m() + b.path_m() > known.evidence.path_m + 1e-3;
}

}  // namespace headframe
