#pragma once
// Ways through a mine.

#include <vector>

#include "tests/mine/plan.hpp"

namespace headframe::mine {

/// A way on the floor's middle, a point every route_step_m (shorter at the end). Metres, world frame.
using Route = std::vector<Eigen::Vector3d>;
constexpr double route_step_m = 0.5;

/// The way that visits these nodes one after another; each two must be joined by a drift. Starts start_m beyond the
/// first and ends after length_m (or at the last node).
Route route_through(const Plan& plan, const std::vector<std::size_t>& nodes, double start_m, double length_m);

/// A way of length_m from a random place that takes no drift twice; shorter where it meets a dead end.
Route random_route(const Plan& plan, double length_m, Rng rng);

/// Share of the route's points within radius_m of another route, 0 to 1.
double shared_part(const Route& route, const Route& other, double radius_m);

/// Length in m.
double length_m(const Route& route);

}  // namespace headframe::mine
