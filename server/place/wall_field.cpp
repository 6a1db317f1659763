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
  const std::size_t count = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  for_wall_.resize(count + worth_padding);
  for_free_.resize(count + worth_padding);
  const auto index = [&](const Eigen::Vector2f& p) {
    const Eigen::Vector2i c = ((p - low_) / cell_m_).cast<int>();
    return static_cast<std::ptrdiff_t>(c.y()) * columns_ + c.x();
  };
  const auto set = static_cast<std::int8_t>(-wall_penalty);
  for (const auto& p : map.free) for_wall_[static_cast<std::size_t>(index(p))] = set;
  for (const auto& p : map.walls)
    for (std::ptrdiff_t dy = -1; dy <= 1; ++dy)
      for (std::ptrdiff_t dx = -1; dx <= 1; ++dx)
        for_wall_[static_cast<std::size_t>(index(p) + dy * columns_ + dx)] = 1;
  for (const auto& p : map.walls) for_free_[static_cast<std::size_t>(index(p))] = set;
  mark_reach();
}

void WallField::mark_reach() {
  reach_columns_ = columns_ / block + 1;
  const int reach_rows = rows_ / block + 1;
  reach_.resize(static_cast<std::size_t>(reach_columns_) * static_cast<std::size_t>(reach_rows) + 1);
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < columns_; ++x) {
      const auto cell = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
      if (for_wall_[cell] == 0 && for_free_[cell] == 0) continue;
      for (int by = std::max(0, y / block - 1); by <= std::min(reach_rows - 1, y / block + 1); ++by)
        for (int bx = std::max(0, x / block - 1); bx <= std::min(reach_columns_ - 1, x / block + 1); ++bx)
          reach_[static_cast<std::size_t>(by) * static_cast<std::size_t>(reach_columns_) +
                 static_cast<std::size_t>(bx)] = 1;
    }
}

/// The cells of b that the guess brings near to non-empty cells of the field.
WallMap WallField::near_part(const WallMap& b, const WallMatch& guess,
                             const std::optional<Surroundings>& within) const {
  const OnGrid cells_of_a = on_grid(guess);
  const OnGrid blocks{cells_of_a.R / block, cells_of_a.t / block, cells_of_a.size / block, reach_columns_};
  const auto outside = static_cast<std::int32_t>(reach_.size()) - 1;
  const Eigen::Vector2f centre = within ? within->centre_m.cast<float>().eval() : Eigen::Vector2f::Zero();
  const float r2 = within ? static_cast<float>(within->radius_m * within->radius_m) : std::numeric_limits<float>::max();
  const auto take = [&](std::span<const Eigen::Vector2f> from, std::vector<Eigen::Vector2f>& to) {
    CellIndices cells;
    to.resize(from.size());
    std::size_t taken = 0;
    while (!from.empty()) {
      const std::size_t count = cells_under(from, blocks, 0, outside, cells);
      for (std::size_t i = 0; i < count; ++i) {
        to[taken] = from[i];
        taken += reach_[static_cast<std::size_t>(cells[i])] != 0 && (from[i] - centre).squaredNorm() <= r2;
      }
      from = from.subspan(count);
    }
    to.resize(taken);
  };
  WallMap out{{}, {}, b.cell_m};
  if (for_wall_.empty()) return out;
  take(b.walls, out.walls);
  take(b.free, out.free);
  return out;
}

OnGrid WallField::on_grid(const Eigen::Matrix2f& turn, const Eigen::Vector2f& shift) const {
  return {turn / cell_m_, (shift - low_) / cell_m_, Eigen::Vector2i(columns_, rows_).cast<float>(), columns_};
}

/// Shifts are whole cells: each cell of b is transformed once and looked up at all of them.
WallField::Best WallField::best_within(const WallMap& b, const OnGrid& grid, CellWindow window,
                                       std::size_t every) const {
  const std::size_t side = window.side();
  std::vector<std::int32_t> scores(side * side);
  if (!for_wall_.empty()) {
    add_windows(b.walls, every, grid, for_wall_, window, scores);
    add_windows(b.free, every, grid, for_free_, window, scores);
  }
  const auto most = std::max_element(scores.begin(), scores.end());
  const auto at = static_cast<int>(most - scores.begin()), columns = static_cast<int>(side);
  return {*most, Eigen::Vector2i(at % columns, at / columns) * window.stride - Eigen::Vector2i::Constant(window.reach)};
}

/// Calls act(worth, point) for each of the points.
template <class Act>
void WallField::look_up(std::span<const Eigen::Vector2f> points, const OnGrid& grid, const CellWorth& worth,
                        Act&& act) {
  CellIndices cells;
  while (!points.empty() && !worth.empty()) {
    const std::size_t count = cells_under(points, grid, 0, 0, cells);
    for (std::size_t i = 0; i < count; ++i) act(worth[static_cast<std::size_t>(cells[i])], points[i]);
    points = points.subspan(count);
  }
}

WallFit WallField::fit(const WallMap& b, const WallMatch& m, const std::optional<Surroundings>& within) const {
  if (within) return fit(near_part(b, m, within), m);
  WallFit out;
  const OnGrid grid = on_grid(m);
  look_up(b.walls, grid, for_wall_, [&](int worth, const Eigen::Vector2f& p) {
    out.contradicted += worth < 0;
    out.met += worth > 0;
    out.middle += (worth > 0 ? 1 : 0) * p.cast<double>();
  });
  look_up(b.free, grid, for_free_, [&](int worth, const Eigen::Vector2f&) { out.contradicted += worth < 0; });
  if (out.met > 0) out.middle /= out.met;
  return out;
}

double WallField::score(const WallMap& b, const WallMatch& m) const {
  int sum = 0;  // a wall on a wall is worth 1, a contradiction -wall_penalty
  const auto add = [&](int worth, const Eigen::Vector2f&) { sum += worth; };
  const OnGrid grid = on_grid(m);
  look_up(b.walls, grid, for_wall_, add);
  look_up(b.free, grid, for_free_, add);
  return sum;
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
    CellWindow window;
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
          const Best found = best_within(part, on_grid(R.cast<float>(), shift.cast<float>()), round.window, every);
          if (found.score <= most) continue;
          most = found.score;
          best = {wrap_rad(yaw), shift + cell_m * found.cells.cast<double>(), 0};
        }
    }
  }
  return best;
}

}  // namespace headframe
