#pragma once
// A session's path as a chain of the pose graph: which keyframes become nodes, and how well odometry knows one from the
// one before.

#include <set>
#include <vector>

#include "server/atlas/pose_graph.hpp"
#include "server/merge/session_map.hpp"

namespace headframe {

/// What odometry is taken to be off by. Set by hand: about 0.3 m and 0.5 deg over 100 m, which bends to 0.5 m at the
/// end.
struct OdometryNoise {
  double metres = 0.03;         // after a metre; it grows with the root of the path
  double radians = 0.0009;      // the same of the heading and, as gravity is known, a part of it of the tilt
  double of_turning = 0.005;    // rad more for each rad that was turned through
  double least_metres = 0.003;  // keyframes may lie close together
  double least_radians = 0.0002;
};

/// Indices of the keyframes that are nodes: the first, the last, those that are asked for, and so many between that no
/// two lie farther apart than spacing_m of path, where keyframes are so dense. Ascending.
std::vector<std::size_t> chain_nodes(const Session& session, const std::set<std::size_t>& asked, double spacing_m = 10);

/// T_from_to of two keyframes of a session as its odometry knows it; from, to: their nodes.
PoseEdge odometry_edge(const Session& session, std::size_t keyframe_from, std::size_t keyframe_to, std::size_t from,
                       std::size_t to, const OdometryNoise& noise = {});

}  // namespace headframe
