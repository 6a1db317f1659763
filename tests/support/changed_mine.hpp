#pragma once
// A mine that is worked: what stands in it at one date, and at another.

#include "tests/bench/driven_session.hpp"

namespace headframe::test {

/// What happened to the mine between two dates. elsewhere: nothing, it is another one, whose rock is the same from 0 to
/// 2 and in the stope; from 2 on its drifts lead elsewhere.
enum class Work { nothing, advanced_face, slashed_wall, parked_machine, backfilled_stope, ventilation_door, elsewhere };

/*      4 stope
 *      |
 *  0---1-------2-----3 face      34 m from node to node, rough walls, 5 m wide
 *              |
 *              5                                                                          */
mine::Plan worked_mine(Work done, std::uint64_t rock_seed = 1);

/// Where it is, in the mine's frame.
Eigen::Vector3d place_of(Work work);

/// A drive through these nodes of the mine at a date, in seconds since 1970. The drives of one mine are drawn by name.
bench::DrivenSession drive_at(const mine::World& world, const std::string& name, const std::vector<std::size_t>& nodes,
                              double stamp_s);

}  // namespace headframe::test
