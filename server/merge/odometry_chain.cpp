#include "server/merge/odometry_chain.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

const Pose& pose_of(const Session& session, std::size_t keyframe) { return session.keyframes[keyframe].T_local_sensor; }

double turned_rad(const Session& session, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i)
    sum += rotation_angle_rad(pose_of(session, i).inverse() * pose_of(session, i + 1));
  return sum;
}

}  // namespace

std::vector<std::size_t> chain_nodes(const Session& session, const std::set<std::size_t>& asked, double spacing_m) {
  const std::size_t n = session.keyframes.size();
  std::vector<std::size_t> nodes;
  for (std::size_t i = 0; i < n; ++i) {
    const bool far = i + 1 < n && i > 0 && session.path_to_m[i + 1] - session.path_to_m[nodes.back()] > spacing_m;
    if (i == 0 || i + 1 == n || far || asked.contains(i)) nodes.push_back(i);
  }
  return nodes;
}

PoseEdge odometry_edge(const Session& session, std::size_t keyframe_from, std::size_t keyframe_to, std::size_t from,
                       std::size_t to, const OdometryNoise& noise) {
  const double path_m = session.path_to_m[keyframe_to] - session.path_to_m[keyframe_from];
  const double m = std::max(noise.least_metres, noise.metres * std::sqrt(path_m));
  const double rad =
      std::max(noise.least_radians, std::hypot(noise.radians * std::sqrt(path_m),
                                               noise.of_turning * turned_rad(session, keyframe_from, keyframe_to)));
  return {from, to, pose_of(session, keyframe_from).inverse() * pose_of(session, keyframe_to), information_of(rad, m)};
}

}  // namespace headframe
