#include "tests/support/changed_mine.hpp"

#include <numbers>

#include "tests/mine/lattice.hpp"

namespace headframe::test {
namespace {

constexpr double width_m = 5, height_m = 3.8;

/// A place in the middle of a straight drift, left_m left of it and up_m above its floor.
Eigen::Vector3d beside(const mine::Drift& drift, double share, double left_m, double up_m) {
  const Eigen::Vector3d a = drift.line.front(), along = drift.line.back() - a;
  const Eigen::Vector3d left = Eigen::Vector3d(-along.y(), along.x(), 0).normalized();
  return a + share * along + left_m * left + Eigen::Vector3d(0, 0, up_m);
}

/// The middle of the face: a drift's end is as round as it is wide.
Eigen::Vector3d end_of(const mine::Drift& drift) {
  const Eigen::Vector3d ahead = (drift.line.back() - drift.line.front()).normalized();
  return beside(drift, 1, 0, 1.9) + 0.4 * width_m * ahead;
}

double yaw_of(const mine::Drift& drift) {
  const Eigen::Vector3d along = drift.line.back() - drift.line.front();
  return std::atan2(along.y(), along.x());
}

}  // namespace

mine::Plan worked_mine(Work done, std::uint64_t rock_seed) {
  mine::Plan plan;
  plan.rock_seed = rock_seed;
  const bool advanced = done == Work::advanced_face, filled = done == Work::backfilled_stope;
  const bool elsewhere = done == Work::elsewhere;
  const Eigen::Vector3d two(68, -3, 0.6);
  const Eigen::Vector3d ahead = Eigen::Vector3d(elsewhere ? 12 : 30, elsewhere ? 28 : 6, 0.2).normalized();
  const Eigen::Vector3d one(34, 4, 0.3), into_stope = Eigen::Vector3d(-6, 34, 0.4).normalized();
  plan.nodes = {{0, 0, 0},
                one,
                two,
                two + (advanced ? 44 : 34) * ahead,
                one + (filled ? 6 : 34) * into_stope,
                elsewhere ? Eigen::Vector3d(96, -22, 0.2) : Eigen::Vector3d(74, -37, 0.2)};
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 2}, {2, 3}, {1, 4}, {2, 5}})
    mine::add_drift(plan, a, b, 0, width_m, height_m);
  const mine::Drift &between = plan.drifts[1], &south = plan.drifts[4];
  if (done == Work::slashed_wall)
    plan.niches.push_back({beside(between, 0.5, 0.5 * width_m, 1.6), {6, 1.6, 1.6}, yaw_of(between)});
  if (done == Work::parked_machine)
    plan.vehicles.push_back({beside(between, 0.5, 1, 1.1), {2.5, 0.8, 1.0}, yaw_of(between)});
  if (done == Work::ventilation_door)
    plan.vehicles.push_back({beside(south, 0.25, 0, 2), {0.15, 0.6 * width_m, 2.5}, yaw_of(south)});
  return plan;
}

Eigen::Vector3d place_of(Work work) {
  const mine::Plan plan = worked_mine(work);
  switch (work) {
    case Work::advanced_face: return end_of(worked_mine(Work::nothing).drifts[2]);
    case Work::slashed_wall: return beside(plan.drifts[1], 0.5, 0.5 * width_m, 1.6);
    case Work::parked_machine: return plan.vehicles.front().centre;
    case Work::backfilled_stope: return end_of(plan.drifts[3]);
    case Work::ventilation_door: return plan.vehicles.front().centre;
    case Work::nothing:
    case Work::elsewhere: break;
  }
  return Eigen::Vector3d::Zero();
}

bench::DrivenSession drive_at(const mine::World& world, const std::string& name, const std::vector<std::size_t>& nodes,
                              double stamp_s) {
  mine::Robot robot{.name = name, .lidar = *mine::lidar_model("os1-32")};
  robot.style.frame_yaw_rad = 0.7 * static_cast<double>(nodes.front()) + 0.3;
  robot.route = mine::route_through(world.regions.front(), nodes, 2, 1e3);
  while (robot.route.size() > 6 && (robot.route.back() - world.regions.front().nodes[nodes.back()]).norm() < 3)
    robot.route.pop_back();
  bench::DrivenSession session = bench::drive_robot(world, robot, 7, "changed", stamp_s);
  session.world = "worked mine";
  return session;
}

}  // namespace headframe::test
