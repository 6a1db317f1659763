#pragma once
// The rock around one spot of a session's path, computed once and kept, so that a merge only has to pay for
// registration.

#include <memory>
#include <span>
#include <vector>

#include "server/registration/registration_engine.hpp"
#include "server/registration/vgicp.hpp"
#include "server/verification/free_space.hpp"
#include "server/verification/recorded.hpp"

namespace headframe {

struct SubmapConfig {
  double window_m = 45;              // uses clouds within this much path, both ways; later visits have drifted ...
  double farthest_m = 40;            // ... of keyframes within this distance, because others add nothing
  double radius_m = 18;              // of the source of a registration ...
  double slack_m = 6;                // ... and by how much the target's is larger
  float leaf_m = 0.2F;               // one surfel per cube of this edge
  std::size_t source_points = 8000;  // limit
  double beside_m = 5;               // two keyframes this near see the same rock, farther apart only a part of it
  double look_m = 15;                // free space is checked at points nearer than this to the keyframe ...
  float look_leaf_m = 0.6F;          // ... one per cube of this edge ...
  double view_reach_m = 25;          // ... from sweeps taken nearer than this ...
  float look_slack_m = 0;            // ... with this much more tolerance, for drift between the sweep and the point
  RegistrationEngine engine = RegistrationEngine::vgicp;
};

/// The surroundings of a keyframe, all in the session's local frame. Immutable; may be shared between threads.
struct Submap {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // position of the keyframe
  SurfelCloud source;                           // of a registration
  VoxelMaps target;
  double scatter_m = 0;  // of the source about the target's surfaces: how rough the rock is, and the lidar's noise
  SurfelCloud rock;      // without what its own sweeps see through
  std::vector<PlacedView> views;
  Recorded recorded;
};
using SubmapPtr = std::shared_ptr<const Submap>;

/// The submaps of both sessions at one place of the overlap.
struct SubmapPair {
  SubmapPtr a, b;
};

/// Without the images of its views, which belong to its clouds and are shared with other submaps.
std::size_t bytes_of(const Submap& submap);

/// Builds the submap around p from the clouds of the window, in the order of their sequence. Pure.
Submap make_submap(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p, const SubmapConfig& config);

}  // namespace headframe
