#include "server/place/wall_field.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <span>

#include "common/geometry/se3.hpp"

namespace headframe {
namespace {

constexpr int block = 8;                   // cells: 4 m, about as far as a refinement moves a cell
constexpr std::size_t coarse_cells = 300;  // limit of b's cells that a coarse refinement uses
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
  mark_reach();
}

void WallField::mark_reach() {
  reach_columns_ = columns_ / block + 1;
  const int reach_rows = rows_ / block + 1;
  reach_.resize(static_cast<std::size_t>(reach_columns_) * static_cast<std::size_t>(reach_rows));
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < columns_; ++x) {
      const Cell& cell =
          cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
      if (cell.for_wall == 0 && cell.for_free == 0) continue;
      for (int by = std::max(0, y / block - 1); by <= std::min(reach_rows - 1, y / block + 1); ++by)
        for (int bx = std::max(0, x / block - 1); bx <= std::min(reach_columns_ - 1, x / block + 1); ++bx)
          reach_[static_cast<std::size_t>(by) * static_cast<std::size_t>(reach_columns_) +
                 static_cast<std::size_t>(bx)] = 1;
    }
}

/// The cells of b that the guess brings near to non-empty cells of the field.
WallMap WallField::near_part(const WallMap& b, const WallMatch& guess,
                             const std::optional<Surroundings>& within) const {
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(guess.yaw_rad)).toRotationMatrix() / cell_m_;
  const Eigen::Vector2f t = (guess.shift_m.cast<float>() - low_) / cell_m_;
  const Eigen::Vector2f centre = within ? within->centre_m.cast<float>().eval() : Eigen::Vector2f::Zero();
  const auto r2 = static_cast<float>(within ? within->radius_m * within->radius_m : 0);
  const auto take = [&](const std::vector<Eigen::Vector2f>& from, std::vector<Eigen::Vector2f>& to) {
    for (const Eigen::Vector2f& p : from) {
      if (within && (p - centre).squaredNorm() > r2) continue;
      const Eigen::Vector2f c = R * p + t;
      if (!(c.x() >= 0 && c.y() >= 0 && c.x() < static_cast<float>(columns_) && c.y() < static_cast<float>(rows_)))
        continue;
      const int bx = static_cast<int>(c.x()) / block, by = static_cast<int>(c.y()) / block;
      if (reach_[static_cast<std::size_t>(by) * static_cast<std::size_t>(reach_columns_) +
                 static_cast<std::size_t>(bx)])
        to.push_back(p);
    }
  };
  WallMap out{{}, {}, b.cell_m};
  if (cells_.empty()) return out;
  take(b.walls, out.walls);
  take(b.free, out.free);
  return out;
}

/// Shifts are whole cells: each cell of b is transformed once and looked up at all of them.
WallField::Best WallField::best_within(const WallMap& b, const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift,
                                       Window window, std::size_t every) const {
  const Eigen::Matrix2f R = turn / cell_m_;
  const Eigen::Vector2f t = (shift - low_) / cell_m_;
  const auto margin = static_cast<float>(window.reach);  // nearer to the edge, all cells of the window are empty
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

WallFit WallField::fit(const WallMap& b, const WallMatch& m, const std::optional<Surroundings>& within) const {
  if (within) return fit(near_part(b, m, within), m);
  WallFit out;
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(m.yaw_rad)).toRotationMatrix() / cell_m_;
  const Eigen::Vector2f t = (m.shift_m.cast<float>() - low_) / cell_m_;
  const auto cell_at = [&](const Eigen::Vector2f& p) -> Cell {
    const Eigen::Vector2f c = R * p + t;
    if (!(c.x() >= 0 && c.y() >= 0 && c.x() < static_cast<float>(columns_) && c.y() < static_cast<float>(rows_)))
      return {};
    return cells_[static_cast<std::size_t>(c.y()) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(c.x())];
  };
  for (const auto& p : b.walls) {
    const int worth = cell_at(p).for_wall;
    out.contradicted += worth < 0;
    if (worth <= 0) continue;
    ++out.met;
    out.middle += p.cast<double>();
  }
  for (const auto& p : b.free) out.contradicted += cell_at(p).for_free < 0;
  if (out.met > 0) out.middle /= out.met;
  return out;
}

WallMatch WallField::refine(const WallMap& b, const WallMatch& guess, Step step,
                            const std::optional<Surroundings>& within) const {
  const WallMap part = near_part(b, guess, within);
  const std::size_t cells = part.walls.size() + part.free.size();
  if (cells == 0) return {guess.yaw_rad, guess.shift_m, 0};
  // Rotations are about the middle of the matching cells, so that they do not shift these.
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto* list : {&part.walls, &part.free})
    for (const auto& p : *list) middle += p.cast<double>() / static_cast<double>(cells);
  const double cell_m = static_cast<double>(cell_m_);
  struct Round {
    Window window;
    int turns;
    double turn_deg;
    bool between;  // whether to try half cells too
  };
  static constexpr std::array coarse{Round{{6, 2}, 2, 2, false}};
  static constexpr std::array fine{Round{{2, 1}, 1, 1, false}, Round{{0, 1}, 1, 1, true}};
  const std::size_t every = step == Step::coarse ? 1 + cells / coarse_cells : 1;
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
          const Best found = best_within(part, R.cast<float>(), shift.cast<float>(), round.window, every);
          if (found.score <= most) continue;
          most = found.score;
          best = {wrap_rad(yaw), shift + cell_m * found.cells.cast<double>(), 0};
        }
    }
  }
  best.score = fit(b, best).score();
  return best;
}

}  // namespace headframe
