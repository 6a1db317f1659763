#pragma once
// What makes a place a junction: the ways that lead on from it, as a lidar there would see them.

#include <vector>

#include "common/geometry/se3.hpp"
#include "tests/mine/ray_caster.hpp"

namespace headframe::mine {

/// How many ways lead on: runs of azimuth, at least 6 deg wide and 4 deg apart, in which the level view from the pose
/// goes on for four times the room at the sides (its lower sixth over all azimuths), 6 m at least. A drift has two, its
/// dead end one, a junction three or more.
int open_directions(const RayCaster& caster, const Pose& T_world_sensor);

/// The same for a view of equal sectors, a range each in metres.
int open_directions(const std::vector<double>& range_m);

}  // namespace headframe::mine
