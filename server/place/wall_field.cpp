#include "server/place/wall_field.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <span>

#include "common/geometry/se3.hpp"

namespace headframe {
namespace {

constexpr int rim = 14;  // empty cells around a field: twice the widest window of a refinement, and a wall's smear

}  // namespace

WallBox::WallBox(const WallMap& map) {
  for (const auto* list : {&map.walls, &map.free})
    for (const auto& p : *list) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
}

Eigen::Vector2d middle_at(const WallMatch& m, const Eigen::Vector2d& middle) {
  return Eigen::Rotation2Dd(m.yaw_rad) * middle + m.shift_m;
}

WallField::WallField(const WallMap& map) : cell_m_(map.cell_m), low_(Eigen::Vector2f::Zero()) {
  if (map.walls.empty() && map.free.empty()) return;
  const WallBox box(map);
  low_ = box.low.array() - (static_cast<float>(rim) + 0.5F) * cell_m_;  // centres of the map fall on centres
  const Eigen::Vector2f cells = (box.high - low_) / cell_m_;
  columns_ = static_cast<int>(cells.x()) + rim + 2;
  rows_ = static_cast<int>(cells.y()) + rim + 2;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  const auto index = [&](const Eigen::Vector2f& p) {
    const Eigen::Vector2i c = ((p - low_) / cell_m_).cast<int>();
    return static_cast<std::ptrdiff_t>(c.y()) * columns_ + c.x();
  };
  const auto set = static_cast<std::int8_t>(-wall_penalty);
  for (const auto& p : map.free) cells_[static_cast<std::size_t>(index(p))].for_wall = set;
  for (const auto& p : map.walls)
    for (std::ptrdiff_t dy = -1; dy <= 1; ++dy)
      for (std::ptrdiff_t dx = -1; dx <= 1; ++dx)
        cells_[static_cast<std::size_t>(index(p) + dy * columns_ + dx)].for_wall = 1;
  for (const auto& p : map.walls) cells_[static_cast<std::size_t>(index(p))].for_free = set;
}

/// Shifts by whole cells: each cell of b is placed once and read at all of them.
WallField::Best WallField::best_within(const WallMap& b, const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift,
                                       Window window, std::size_t every) const {
  const Eigen::Matrix2f R = turn / cell_m_;
  const Eigen::Vector2f t = (shift - low_) / cell_m_;
  const auto margin = static_cast<float>(window.reach);  // nearer to the edge all cells of the window are empty
  const float width = static_cast<float>(columns_) - margin, height = static_cast<float>(rows_) - margin;
  const int side = 2 * window.reach / window.stride + 1;
  std::vector<int> scores(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  const auto add = [&](const std::vector<Eigen::Vector2f>& points, std::int8_t Cell::*worth) {
    for (std::size_t i = 0; i < points.size(); i += every) {
      const Eigen::Vector2f& p = points[i];
      const float x = R(0, 0) * p.x() + R(0, 1) * p.y() + t.x(), y = R(1, 0) * p.x() + R(1, 1) * p.y() + t.y();
      if (!(x >= margin && y >= margin && x < width && y < height)) continue;
      const std::ptrdiff_t corner = static_cast<std::ptrdiff_t>(static_cast<int>(y) - window.reach) * columns_ +
                                    static_cast<int>(x) - window.reach;
      int* score = scores.data();
      for (int row = 0; row < side; ++row) {
        const Cell* cell = cells_.data() + corner + static_cast<std::ptrdiff_t>(row * window.stride) * columns_;
        for (int column = 0; column < side; ++column, cell += window.stride) *score++ += cell->*worth;
      }
    }
  };
  if (!cells_.empty()) {
    add(b.walls, &Cell::for_wall);
    add(b.free, &Cell::for_free);
  }
  const auto most = std::max_element(scores.begin(), scores.end());
  const auto at = static_cast<int>(most - scores.begin());
  return {*most, Eigen::Vector2i(at % side, at / side) * window.stride - Eigen::Vector2i::Constant(window.reach)};
}

double WallField::score(const WallMap& b, const WallMatch& m) const {
  const Eigen::Matrix2f turn = Eigen::Rotation2Df(static_cast<float>(m.yaw_rad)).toRotationMatrix();
  return best_within(b, turn, m.shift_m.cast<float>(), {}, 1).score;
}

WallMatch WallField::refine(const WallMap& b, const WallMatch& guess, Step step) const {
  const Eigen::Vector2d middle = WallBox(b).middle().cast<double>();  // turns are about it, so that they do not shift b
  const double cell_m = static_cast<double>(cell_m_);
  struct Round {
    Window window;
    int turns;
    double turn_deg;
    std::size_t every;
    bool between;  // half a cell off as well
  };
  static constexpr std::array coarse{Round{{6, 2}, 2, 2, 3, false}};
  static constexpr std::array fine{Round{{2, 1}, 1, 1, 1, false}, Round{{0, 1}, 1, 1, 1, true}};
  WallMatch best = guess;
  for (const Round& round : step == Step::coarse ? std::span<const Round>(coarse) : std::span<const Round>(fine)) {
    const WallMatch from = best;
    const Eigen::Vector2d at = middle_at(from, middle);
    int most = std::numeric_limits<int>::min();
    const int half = round.between ? 1 : 0;
    for (int turn = -round.turns; turn <= round.turns; ++turn) {
      const double yaw = from.yaw_rad + turn * round.turn_deg * std::numbers::pi / 180;
      const Eigen::Matrix2d R = Eigen::Rotation2Dd(yaw).toRotationMatrix();
      for (int y = -half; y <= half; ++y)
        for (int x = -half; x <= half; ++x) {
          const Eigen::Vector2d shift = at + 0.5 * cell_m * Eigen::Vector2d(x, y) - R * middle;
          const Best found = best_within(b, R.cast<float>(), shift.cast<float>(), round.window, round.every);
          if (found.score <= most) continue;
          most = found.score;
          best = {wrap_rad(yaw), shift + cell_m * found.cells.cast<double>(), 0};
        }
    }
  }
  best.score = score(b, best);
  return best;
}

}  // namespace headframe
