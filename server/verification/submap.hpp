#pragma once
// What a session knows of the rock around one spot of its path, summed up once and kept, so that a merge pays for
// alignment alone.

#include <memory>
#include <span>
#include <vector>

#include "server/registration/registration_engine.hpp"
#include "server/registration/vgicp.hpp"
#include "server/verification/free_space.hpp"
#include "server/verification/recorded.hpp"

namespace headframe {

struct SubmapConfig {
  double window_m = 45;              // clouds of so much path each way; what came by another time has drifted
  double radius_m = 18;              // of the source of a registration ...
  double slack_m = 6;                // ... and so much more of its target
  float leaf_m = 0.2F;               // one surfel per cube of this edge
  std::size_t source_points = 8000;  // at most
  double look_m = 15;                // free space is asked of points nearer than this to the keyframe ...
  float look_leaf_m = 0.6F;          // ... one per cube of this edge ...
  double view_reach_m = 25;          // ... from sweeps that were taken nearer than this
  RegistrationEngine engine = RegistrationEngine::vgicp;
};

/// The surroundings of a keyframe, all in the session's local frame. Immutable; shared between threads.
struct Submap {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // where the keyframe stood
  SurfelCloud source;                           // of a registration
  VoxelMaps target;
  SurfelCloud rock;  // without what its own sweeps see through
  std::vector<PlacedView> views;
  Recorded recorded;
};
using SubmapPtr = std::shared_ptr<const Submap>;

/// Without the images of its views, which are its clouds' and shared with its neighbours.
std::size_t bytes_of(const Submap& submap);

/// The submap around p, of the clouds of the window in the order of their sequence. Pure.
Submap make_submap(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p, const SubmapConfig& config);

}  // namespace headframe
