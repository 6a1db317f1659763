#pragma once
// The mine as a field: how far a place is inside the rock.

#include <cstddef>
#include <span>
#include <vector>

#include "tests/mine/plan.hpp"

namespace headframe::mine {

/// Signed depth of a plan's rock: negative in the open, positive in the rock, in metres but not exact away from the
/// surface. Flat-ish floors, arched roofs, drifts blended into each other at junctions. Immutable, thread safe. Keeps a
/// pointer to the plan, which has to outlive it.
class Rock {
 public:
  /// What is near a place, so that a block of the mesh looks at few drifts.
  struct Nearby {
    struct Segment {
      const Drift* drift;
      Eigen::Vector3d a, b;
    };
    std::vector<Segment> segments;
    std::vector<const Box*> niches;
    std::vector<const Pile*> piles;
  };

  explicit Rock(const Plan& plan) : plan_(&plan) {}

  /// All that shapes the rock within radius_m of the centre.
  Nearby nearby(const Eigen::Vector3d& centre, double radius_m) const;

  /// Depth at p; p has to be within the sphere that `near` was made for.
  double depth_m(const Eigen::Vector3d& p, const Nearby& near) const;

  /// Depth at any place. Slower: looks for what is nearby first.
  double depth_m(const Eigen::Vector3d& p) const { return depth_m(p, nearby(p, 0.1)); }

 private:
  double roughness_m(const Eigen::Vector3d& p, double floor_weight) const;

  const Plan* plan_;
};

}  // namespace headframe::mine
