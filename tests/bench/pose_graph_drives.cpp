#include <algorithm>
#include <deque>
#include <optional>

#include "tests/bench/pose_graph.hpp"

namespace headframe::bench {
namespace {

constexpr double shortest_m = 150, longest_m = 420;

double length_m(const mine::Drift& drift) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < drift.line.size(); ++i) sum += (drift.line[i + 1] - drift.line[i]).norm();
  return sum;
}

/// The way from one end of the drift to the other that does not lead through it, over the fewest nodes; empty: none.
std::vector<std::size_t> way_round(const mine::Plan& plan, const mine::Drift& without) {
  std::vector<std::optional<std::size_t>> came_from(plan.nodes.size());
  std::deque<std::size_t> reached{without.a};
  came_from[without.a] = without.a;
  for (; !reached.empty() && !came_from[without.b]; reached.pop_front())
    for (const mine::Drift& drift : plan.drifts) {
      if (&drift == &without || (drift.a != reached.front() && drift.b != reached.front())) continue;
      const std::size_t next = drift.a == reached.front() ? drift.b : drift.a;
      if (came_from[next]) continue;
      came_from[next] = reached.front();
      reached.push_back(next);
    }
  std::vector<std::size_t> way;
  if (!came_from[without.b]) return way;
  for (std::size_t at = without.b; at != without.a; at = *came_from[at]) way.push_back(at);
  way.push_back(without.a);
  return way;
}

struct Round {
  std::vector<std::size_t> nodes;  // the last is joined to the first
  double length_m = 0;
};

/// The longest of the plan's small loops.
Round loop_of(const mine::Plan& plan) {
  Round best;
  for (const mine::Drift& drift : plan.drifts) {
    Round round{way_round(plan, drift), length_m(drift)};
    if (round.nodes.size() < 3) continue;
    for (std::size_t i = 0; i + 1 < round.nodes.size(); ++i)
      for (const mine::Drift& other : plan.drifts)
        if (std::minmax(other.a, other.b) == std::minmax(round.nodes[i], round.nodes[i + 1])) {
          round.length_m += length_m(other);
          break;
        }
    if (round.length_m > best.length_m && round.length_m >= shortest_m && round.length_m <= longest_m) best = round;
  }
  return best;
}

}  // namespace

DrivenMine drive_loop(mine::Kind kind, std::uint64_t seed, double drift, Loop loop) {
  const mine::World world = mine::build_world({mine::make_plan(kind, seed)});
  const mine::Plan& plan = world.regions.front();
  const Round round = loop_of(plan);
  if (round.nodes.empty()) return {};
  std::vector<std::size_t> there = round.nodes;
  there.insert(there.end(), round.nodes.begin(), round.nodes.end());
  std::vector<std::size_t> back(there.rbegin(), there.rend());  // from the second node on
  back.erase(back.begin(), std::find(back.begin(), back.end(), round.nodes[1]));
  const auto robot = [&](const char* name, const std::vector<std::size_t>& nodes, double start_m, double length,
                         double yaw) {
    mine::Robot out{.name = name, .lidar = *mine::lidar_model("os1-32")};
    out.style.drift = drift;
    out.style.frame_yaw_rad = yaw;
    out.route = mine::route_through(plan, nodes, start_m, length);
    return out;
  };
  const double m = round.length_m;
  DrivenMine out;
  const auto drive = [&](const mine::Robot& r) {
    out.sessions.push_back(drive_robot(world, r, seed, std::string(to_string(kind)) + "-" + std::to_string(seed)));
  };
  if (loop == Loop::one_robot) {
    drive(robot("r1", there, 0, 1.35 * m, 0.3));
  } else {
    drive(robot("r1", there, 0, 0.7 * m, 0.3));
    drive(robot("r2", back, 0, 0.6 * m, -1.2));
  }
  return out;
}

}  // namespace headframe::bench
