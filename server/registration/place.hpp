#pragma once
// What a session knows of the rock around one spot of its path, summed up once and kept, so that a merge pays for
// alignment alone.

#include <memory>
#include <span>
#include <vector>

#include "server/registration/vgicp.hpp"
#include "server/registration/visibility.hpp"

namespace headframe {

struct PlaceConfig {
  double window_m =
      45;  // of the path, each way: what the robot saw of the rock when it came by another time has drifted
  double radius_m = 18;  // of the submap as a source; as a target it reaches slack_m further
  double slack_m = 6;
  float leaf_m = 0.2F;               // of the submap
  std::size_t source_points = 8000;  // kept, at most
  double look_m = 15;                // free space is asked of points nearer than this to the place ...
  float look_leaf_m = 0.6F;          // ... one per leaf
  double view_reach_m = 25;
  double slide_m = 4;  // of the slide test
};

/// All in the session's local frame. Immutable; shared between threads.
struct Place {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Submap source;
  VoxelMaps target;
  Submap rock;  // without what its own sweeps see through
  std::vector<PlacedView> views;
  Visibility own;  // of the rock by every other cloud
};
using PlacePtr = std::shared_ptr<const Place>;

/// Without the images of its views, which are its clouds' and shared with its neighbours.
std::size_t bytes_of(const Place& place);

/// Clouds are those of the window, in the order of their sequence. Pure.
Place make_place(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p, const PlaceConfig& config);

}  // namespace headframe
