#include "server/place/wall_correlation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/geometry/se3.hpp"
#include "server/place/kiss_fft2.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

using Complex = KissFft2::Complex;
constexpr float penalty = 3;  // of a wall where the other map is free, against a wall on a wall
constexpr std::size_t turns = 180;
constexpr std::size_t cells_looked_at = 400, peaks_per_turn = 20, peaks_refined = 100;
constexpr double same_place_m = 5, same_yaw_rad = 20 * std::numbers::pi / 180;

struct Box {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9F), high = Eigen::Vector2f::Constant(-1e9F);
  explicit Box(const WallMap& map) {
    for (const auto* list : {&map.walls, &map.free})
      for (const auto& p : *list) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
  }
  Eigen::Vector2f middle() const { return (low + high) / 2; }
};

/// A dense drawing of map a: what each cell is worth to a wall of b that falls there, and to a free cell of b.
class Drawing {
 public:
  Drawing(const WallMap& map, const Eigen::Vector2f& low, int columns, int rows)
      : low_(low), cell_m_(map.cell_m), columns_(columns), rows_(rows) {
    for_wall.assign(size(), 0);
    for_free.assign(size(), 0);
    for (const auto& p : map.free) set(for_wall, p, 0, 0, -penalty);
    for (const auto& p : map.walls)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) set(for_wall, p, dx, dy, 1);
    for (const auto& p : map.walls) set(for_free, p, 0, 0, -penalty);
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::size_t size() const { return static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_); }
  const Eigen::Vector2f& low() const { return low_; }

  double score(const WallMap& b, const WallMatch& m) const {
    const Eigen::Matrix2f turn = Eigen::Rotation2Df(static_cast<float>(m.yaw_rad)).toRotationMatrix();
    const Eigen::Vector2f shift = m.shift_m.cast<float>();
    double score = 0;
    for (const auto& p : b.walls) score += at(for_wall, turn * p + shift);
    for (const auto& p : b.free) score += at(for_free, turn * p + shift);
    return score;
  }

  /// The best within two half cells and 2 deg, in half cells and degrees.
  WallMatch refine(const WallMap& b, const WallMatch& guess) const {
    WallMatch best = guess;
    best.score = -1e18;
    for (int turn = -2; turn <= 2; ++turn)
      for (int y = -2; y <= 2; ++y)
        for (int x = -2; x <= 2; ++x) {
          WallMatch m = guess;
          m.yaw_rad = wrap_rad(guess.yaw_rad + turn * std::numbers::pi / 180);
          m.shift_m += Eigen::Vector2d(x, y) * (cell_m_ / 2);
          m.score = score(b, m);
          if (m.score > best.score) best = m;
        }
    return best;
  }

  std::vector<float> for_wall, for_free;

 private:
  std::ptrdiff_t cell(const Eigen::Vector2f& p, int dx, int dy) const {
    const int x = static_cast<int>(std::floor((p.x() - low_.x()) / cell_m_)) + dx;
    const int y = static_cast<int>(std::floor((p.y() - low_.y()) / cell_m_)) + dy;
    const bool inside = x >= 0 && y >= 0 && x < columns_ && y < rows_;
    return inside ? static_cast<std::ptrdiff_t>(y) * columns_ + x : -1;
  }
  void set(std::vector<float>& grid, const Eigen::Vector2f& p, int dx, int dy, float value) const {
    if (const auto c = cell(p, dx, dy); c >= 0) grid[static_cast<std::size_t>(c)] = value;
  }
  float at(const std::vector<float>& grid, const Eigen::Vector2f& p) const {
    const auto c = cell(p, 0, 0);
    return c >= 0 ? grid[static_cast<std::size_t>(c)] : 0;
  }

  Eigen::Vector2f low_;
  float cell_m_;
  int columns_, rows_;
};

/// Keeps the best first of those that put b's middle within same_place_m and same_yaw_rad of each other.
void keep_distinct(std::vector<WallMatch>& matches, std::size_t most, const Eigen::Vector2d& middle) {
  const auto same = [&](const WallMatch& m, const WallMatch& n) {
    const auto at = [&](const WallMatch& k) -> Eigen::Vector2d {
      return Eigen::Rotation2Dd(k.yaw_rad) * middle + k.shift_m;
    };
    return (at(m) - at(n)).norm() < same_place_m && std::abs(wrap_rad(m.yaw_rad - n.yaw_rad)) < same_yaw_rad;
  };
  std::stable_sort(matches.begin(), matches.end(), [](const auto& m, const auto& n) { return m.score > n.score; });
  std::vector<WallMatch> kept;
  for (const WallMatch& m : matches) {
    if (kept.size() == most) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const WallMatch& k) { return same(k, m); })) kept.push_back(m);
  }
  matches = std::move(kept);
}

/// The correlation of map b, turned, with the drawing of map a, for all shifts at once. Two real grids (what walls of b
/// meet, what free cells of b meet) share each complex transform and are taken apart by symmetry.
class Correlator {
 public:
  Correlator(const WallMap& a, const WallMap& b)
      : b_(b), middle_b_(Box(b).middle()), span_b_(span_of(b, middle_b_)), a_(make_drawing(a, span_b_)) {
    std::vector<Complex> packed(a_.size()), spectrum(a_.size());
    for (std::size_t i = 0; i < packed.size(); ++i) packed[i] = {a_.for_wall[i], a_.for_free[i]};
    KissFft2(a_.rows(), a_.columns(), KissFft2::Way::forward).run(packed, spectrum);
    for_wall_.resize(a_.size());
    for_free_.resize(a_.size());
    for (std::size_t i = 0; i < a_.size(); ++i) take_apart(spectrum, i, for_wall_[i], for_free_[i]);
  }

  const Drawing& drawing() const { return a_; }
  Eigen::Vector2d middle() const { return middle_b_.cast<double>(); }

  /// Appends the best peaks of the turns in [begin, end), in the order of the turns.
  void search(std::size_t begin, std::size_t end, std::vector<WallMatch>& found) const {
    const KissFft2 forward(a_.rows(), a_.columns(), KissFft2::Way::forward),
        inverse(a_.rows(), a_.columns(), KissFft2::Way::inverse);
    std::vector<Complex> grid(a_.size()), spectrum(a_.size()), scores(a_.size());
    for (std::size_t t = begin; t < end; ++t) {
      const double yaw = static_cast<double>(t) * 2 * std::numbers::pi / turns;
      draw(yaw, grid);
      forward.run(grid, spectrum);
      for (std::size_t i = 0; i < a_.size(); ++i) {
        Complex wall, free;
        take_apart(spectrum, i, wall, free);
        grid[i] = for_wall_[i] * std::conj(wall) + for_free_[i] * std::conj(free);
      }
      inverse.run(grid, scores);
      std::vector<WallMatch> peaks = best_cells(scores, yaw);
      keep_distinct(peaks, peaks_per_turn, middle());
      found.insert(found.end(), peaks.begin(), peaks.end());
    }
  }

 private:
  /// Side, in cells, of a square around b's middle that holds b at any turn.
  static int span_of(const WallMap& b, const Eigen::Vector2f& middle) {
    float radius = 0;
    for (const auto* list : {&b.walls, &b.free})
      for (const auto& p : *list) radius = std::max(radius, (p - middle).norm());
    return static_cast<int>(std::ceil(2 * radius / b.cell_m)) + 3;
  }

  /// Large enough for a and b side by side, so that nothing wraps around.
  static Drawing make_drawing(const WallMap& a, int span_b) {
    const Box box(a);
    const auto cells = [&](int axis) {
      return KissFft2::quick_size(static_cast<int>(std::ceil((box.high[axis] - box.low[axis]) / a.cell_m)) + 3 + span_b);
    };
    return {a, box.low.array() - a.cell_m, cells(0), cells(1)};
  }

  void take_apart(const std::vector<Complex>& spectrum, std::size_t i, Complex& real, Complex& imaginary) const {
    const auto columns = static_cast<std::size_t>(a_.columns()), rows = static_cast<std::size_t>(a_.rows());
    const std::size_t y = i / columns, x = i % columns;
    const Complex s = spectrum[i];
    const Complex m = std::conj(spectrum[(y == 0 ? 0 : rows - y) * columns + (x == 0 ? 0 : columns - x)]);
    real = 0.5F * (s + m);
    imaginary = Complex(0, -0.5F) * (s - m);
  }

  void draw(double yaw, std::vector<Complex>& grid) const {
    std::fill(grid.begin(), grid.end(), Complex());
    const Eigen::Matrix2f turn = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
    const auto cell = [&](const Eigen::Vector2f& p) -> Complex& {
      const Eigen::Vector2f c = turn * (p - middle_b_) / b_.cell_m;
      const int x = static_cast<int>(std::floor(c.x())) + span_b_ / 2,
                y = static_cast<int>(std::floor(c.y())) + span_b_ / 2;
      return grid[static_cast<std::size_t>(y) * static_cast<std::size_t>(a_.columns()) + static_cast<std::size_t>(x)];
    };
    for (const auto& p : b_.walls) cell(p).real(1);
    for (const auto& p : b_.free) cell(p).imag(1);
  }

  std::vector<WallMatch> best_cells(const std::vector<Complex>& scores, double yaw) const {
    std::vector<std::size_t> order(scores.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto better = [&](std::size_t i, std::size_t j) {
      return scores[i].real() > scores[j].real() || (scores[i].real() == scores[j].real() && i < j);
    };
    const std::size_t wanted = std::min(order.size(), cells_looked_at);
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(wanted - 1), order.end(), better);
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(wanted), better);
    std::vector<WallMatch> matches;
    for (std::size_t k = 0; k < wanted; ++k) matches.push_back(match_at(order[k], yaw, scores[order[k]].real()));
    return matches;
  }

  WallMatch match_at(std::size_t i, double yaw, float score) const {
    int x = static_cast<int>(i % static_cast<std::size_t>(a_.columns()));
    int y = static_cast<int>(i / static_cast<std::size_t>(a_.columns()));
    if (x > a_.columns() - span_b_) x -= a_.columns();
    if (y > a_.rows() - span_b_) y -= a_.rows();
    const Eigen::Vector2i cell = Eigen::Vector2i(x, y).array() + span_b_ / 2;
    const Eigen::Vector2d middle_at = (a_.low() + cell.cast<float>() * b_.cell_m).cast<double>();
    return {wrap_rad(yaw), middle_at - Eigen::Rotation2Dd(yaw) * middle(), score / static_cast<double>(a_.size())};
  }

  const WallMap& b_;
  Eigen::Vector2f middle_b_;
  int span_b_;
  Drawing a_;
  std::vector<Complex> for_wall_, for_free_;
};

}  // namespace

std::vector<WallMatch> correlate(const WallMap& a, const WallMap& b, std::size_t most, int threads) {
  if (a.walls.empty() || b.walls.empty()) return {};
  const Correlator correlator(a, b);
  constexpr std::size_t block = 10;
  std::vector<std::vector<WallMatch>> found(turns / block);
  for_blocks(turns, block, threads,
             [&](std::size_t begin, std::size_t end, std::size_t i) { correlator.search(begin, end, found[i]); });
  std::vector<WallMatch> matches;
  for (const auto& list : found) matches.insert(matches.end(), list.begin(), list.end());
  keep_distinct(matches, peaks_refined, correlator.middle());
  for (WallMatch& m : matches) m = correlator.drawing().refine(b, m);
  keep_distinct(matches, most, correlator.middle());
  return matches;
}

WallMatch refine_old(const WallMap& a, const WallMap& b, const WallMatch& guess) {
  const Box box(a);
  const auto cells = [&](int axis) { return static_cast<int>((box.high[axis] - box.low[axis]) / a.cell_m) + 3; };
  if (a.walls.empty() || b.walls.empty()) return guess;
  const Drawing drawing(a, box.low.array() - a.cell_m, cells(0), cells(1));
  return drawing.refine(b, drawing.refine(b, guess));
}

}  // namespace headframe
