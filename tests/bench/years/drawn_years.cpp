#include "tests/bench/years/drawn_years.hpp"

#include <numbers>
#include <random>

namespace headframe::bench {
namespace {

constexpr double keyframe_spacing_m = 3;

struct DrawnMine {
  std::vector<test::Box> boxes;
  std::vector<Eigen::Vector2d> path, branch;  // corners; the branch begins at path's third corner from the end
};

/// A staircase of legs along x and y in turn, so that it never meets itself.
class Digger {
 public:
  explicit Digger(std::uint64_t number) : rng_(number) {}

  DrawnMine dig(double length_m) {
    const double turn = between(0, 1) < 0.5 ? 1 : -1;
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    mine_.path.push_back(at);
    double dug_m = 0;
    for (int leg = 0; dug_m < length_m + 20; ++leg) {
      const double leg_m = between(18, 55);
      const Eigen::Vector2d way = leg % 2 == 0 ? Eigen::Vector2d(1, 0) : Eigen::Vector2d(0, turn);
      tunnel(at, way, leg_m);
      at += leg_m * way;
      dug_m += leg_m;
      mine_.path.push_back(at);
    }
    const std::size_t crossing = mine_.path.size() - 3;
    const Eigen::Vector2d from = mine_.path[crossing], way = (from - mine_.path[crossing - 1]).normalized();
    mine_.branch = {from, from + between(40, 70) * way};
    tunnel(from, way, (mine_.branch[1] - from).norm());
    return std::move(mine_);
  }

 private:
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng_); }

  /// With alcoves at its sides, and now and then a room.
  void tunnel(const Eigen::Vector2d& from, const Eigen::Vector2d& way, double length_m) {
    const Eigen::Vector2d to = from + length_m * way, side(-way.y(), way.x());
    const double width_m = between(3.2, 6.5), height_m = between(2.8, 4.5);
    mine_.boxes.push_back(test::BoxMine::drift(from.x(), from.y(), to.x(), to.y(), width_m, height_m));
    for (double at_m = between(3, 9); at_m < length_m - 3; at_m += between(4, 16)) {
      const Eigen::Vector2d middle = from + at_m * way + (between(0, 1) < 0.5 ? 1 : -1) * width_m / 2 * side;
      const double half_m = between(0, 1) < 0.15 ? between(2, 4) : between(0.4, 1.2);
      mine_.boxes.push_back({{middle.x() - half_m, middle.y() - half_m, 0},
                             {middle.x() + half_m, middle.y() + half_m, between(1.8, height_m)}});
    }
  }

  std::mt19937_64 rng_;
  DrawnMine mine_;
};

test::Drive driven(const DrawnMine& mine, const std::vector<Eigen::Vector2d>& corners, std::uint64_t number,
                   std::size_t keyframes) {
  const double yaw_rad = 2 * std::numbers::pi * static_cast<double>(number % 97) / 97;
  test::Drive drive =
      test::drive(test::BoxMine(mine.boxes), corners, yaw_rad, static_cast<unsigned>(number), keyframe_spacing_m);
  if (drive.keyframes.size() > keyframes) {
    drive.keyframes.resize(keyframes);
    drive.clouds.resize(keyframes);
  }
  return drive;
}

double length_m(std::size_t keyframes) { return keyframe_spacing_m * static_cast<double>(keyframes); }

}  // namespace

test::Drive drawn_drive(std::uint64_t number, std::size_t keyframes) {
  const DrawnMine mine = Digger(number).dig(length_m(keyframes));
  return driven(mine, mine.path, number, keyframes);
}

test::Drive drawn_visit(std::uint64_t number, std::size_t keyframes) {
  const DrawnMine mine = Digger(number).dig(length_m(keyframes));
  // From the branch's end over the crossing, and back along the path that the first came.
  std::vector<Eigen::Vector2d> corners(mine.branch.rbegin(), mine.branch.rend());
  for (std::size_t i = mine.path.size() - 3, left = 3; i-- > 0 && left > 0; --left) corners.push_back(mine.path[i]);
  return driven(mine, corners, number + 1000000, keyframes);
}

}  // namespace headframe::bench
