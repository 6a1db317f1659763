#pragma once
// A session's path as a chain in the pose graph: which keyframes become nodes, and how accurate odometry is between
// them.

#include <set>
#include <vector>

#include "server/atlas/pose_graph.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// Assumed errors of odometry. Set by hand: about 0.3 m and 0.5 deg over 100 m, which bends the path by 0.5 m at its
/// end.
struct OdometryNoise {
  double metres = 0.03;         // after one metre; grows with the square root of the path
  double radians = 0.0009;      // the same for the heading; the tilt gets a part of it, because gravity is known
  double of_turning = 0.005;    // rad more for each rad of turning
  double least_metres = 0.003;  // lower bound, as keyframes may lie close together
  double least_radians = 0.0002;
};

/// Indices of the keyframes that become nodes, ascending: the first, the last, those in `asked`, and enough between
/// them that no two nodes are farther apart than spacing_m of path, if keyframes are that dense.
std::vector<std::size_t> chain_nodes(const Session& session, const std::set<std::size_t>& asked, double spacing_m = 10);

/// T_from_to of two keyframes of a session by odometry; from, to: the indices of their nodes.
PoseEdge odometry_edge(const Session& session, std::size_t keyframe_from, std::size_t keyframe_to, std::size_t from,
                       std::size_t to, const OdometryNoise& noise = {});

}  // namespace headframe
