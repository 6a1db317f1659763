#include "server/place/wall_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>

#include "common/geometry/se3.hpp"
#include "server/place/spectrum.hpp"
#include "server/session/same_placement.hpp"
#include "server/support/parallel.hpp"
#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr float clear_m = 1;        // free ground nearer to a wall says nothing in coarse cells
constexpr float side_share = 0.6F;  // size of the grid as a share of both maps side by side

float radius_m(const WallMap& map, const Eigen::Vector2f& middle) {
  float r2 = 0;
  for (const auto* list : {&map.walls, &map.free})
    for (const auto& p : *list) r2 = std::max(r2, (p - middle).squaredNorm());
  return std::sqrt(r2);
}

/// The map without free cells near its walls, so that being half a coarse cell off puts no free cell on a wall.
WallMap clear_of_walls(const WallMap& map) {
  const WallBox box(map);
  const Eigen::Vector2f low = box.low.array() - clear_m - map.cell_m;
  const int columns = static_cast<int>((box.high.x() - low.x() + clear_m) / map.cell_m) + 2;
  const int rows = static_cast<int>((box.high.y() - low.y() + clear_m) / map.cell_m) + 2;
  std::vector<bool> near(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const auto index = [&](const Eigen::Vector2f& p) {
    const Eigen::Vector2i c = ((p - low) / map.cell_m).cast<int>();
    return static_cast<std::ptrdiff_t>(c.y()) * columns + c.x();
  };
  const auto reach = static_cast<int>(clear_m / map.cell_m);
  for (const auto& p : map.walls)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) near[static_cast<std::size_t>(index(p) + y * columns + x)] = true;
  WallMap out{map.walls, {}, map.cell_m};
  for (const auto& p : map.free)
    if (!near[static_cast<std::size_t>(index(p))]) out.free.push_back(p);
  return out;
}

WallMap every_fourth(const WallMap& map) {
  WallMap out{{}, {}, map.cell_m};
  for (std::size_t i = 0; i < map.walls.size(); i += 4) out.walls.push_back(map.walls[i]);
  for (std::size_t i = 0; i < map.free.size(); i += 4) out.free.push_back(map.free[i]);
  return out;
}

/// Marks the cells of a cyclic row that score more than `least` and no less than the four cells beside them.
HEADFRAME_WIDE void mark_peaks(const float* row, const float* up, const float* down, std::size_t n, float least,
                               std::uint8_t* peak) {
  const auto is_peak = [&](std::size_t x, std::size_t left, std::size_t right) {
    return (row[x] > least) & (row[x] >= up[x]) & (row[x] >= down[x]) & (row[x] >= row[left]) & (row[x] >= row[right]);
  };
  peak[0] = is_peak(0, n - 1, 1);
  for (std::size_t x = 1; x < n - 1; ++x) peak[x] = is_peak(x, x - 1, x + 1);
  peak[n - 1] = is_peak(n - 1, n - 2, 0);
}

/// The first of the marks from `from` on that is set; their number if none is. The C library looks at many at once.
std::size_t next_set(const std::vector<std::uint8_t>& marks, std::size_t from) {
  const void* found = std::memchr(marks.data() + from, 1, marks.size() - from);
  return found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - marks.data()) : marks.size();
}

/// Keeps the least of them, in any order.
template <class T>
void keep_least(std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return;
  const auto end = all.begin() + static_cast<std::ptrdiff_t>(most);
  std::nth_element(all.begin(), end, all.end());
  all.erase(end, all.end());
}

/// Placements as coordinates, so that many are compared at once.
struct Placements {
  std::vector<float> x, y, yaw_rad;  // where the middle of b lies, and how b is turned

  void add(const Eigen::Vector2f& at, float yaw) {
    x.push_back(at.x());
    y.push_back(at.y());
    yaw_rad.push_back(yaw);
  }
};

/// Whether one of the placements from `begin` to `end` is the same as this one (same_wall_peak).
HEADFRAME_WIDE bool any_same(const Placements& all, std::size_t begin, std::size_t end, const Eigen::Vector2f& at,
                             float yaw_rad) {
  constexpr auto reach_m = static_cast<float>(same_wall_peak.metres),
                 reach = static_cast<float>(same_wall_peak.radians);
  constexpr float turn = 2 * std::numbers::pi_v<float>;
  const float *x = all.x.data(), *y = all.y.data(), *yaw = all.yaw_rad.data();
  const float at_x = at.x(), at_y = at.y();
  int same = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const float dx = x[i] - at_x, dy = y[i] - at_y, turned = std::abs(yaw[i] - yaw_rad);
    same += static_cast<int>(dx * dx + dy * dy < reach_m * reach_m) &
            static_cast<int>(std::min(turned, turn - turned) < reach);
  }
  return same > 0;
}

/// The best of those that are different placements.
std::vector<WallMatch> best_distinct(const std::vector<std::vector<WallMatch>>& found, std::size_t most,
                                     const Eigen::Vector2d& middle) {
  constexpr std::size_t at_once = 64;
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> order;  // the best first, then as found
  order.reserve(std::accumulate(found.begin(), found.end(), std::size_t{0},
                                [](std::size_t sum, const auto& list) { return sum + list.size(); }));
  for (std::uint32_t turn = 0; turn < found.size(); ++turn)
    for (std::uint32_t i = 0; i < found[turn].size(); ++i) order.emplace_back(-found[turn][i].score, turn, i);
  keep_least(order, 4 * most);
  std::sort(order.begin(), order.end());
  std::vector<WallMatch> kept;
  Placements known;
  for (const auto& [score, turn, i] : order) {
    if (kept.size() == most) break;
    const WallMatch& m = found[turn][i];
    const Eigen::Vector2f at = middle_at(m, middle).cast<float>();
    const auto yaw = static_cast<float>(m.yaw_rad);
    bool is_known = false;
    for (std::size_t k = 0; k < kept.size() && !is_known; k += at_once)
      is_known = any_same(known, k, std::min(k + at_once, kept.size()), at, yaw);
    if (is_known) continue;
    kept.push_back(m);
    known.add(at, yaw);
  }
  return kept;
}

/// Correlates a rotated b with a for all shifts at once. Grids are cyclic and b's middle lies in cell (0, 0), so that a
/// quarter turn of the drawing is an exact exchange of cells, also in the spectrum: one transform serves four
/// rotations. Walls and free ground are the real and the imaginary part, and two rotations share each inverse
/// transform.
class Correlator {
 public:
  Correlator(const WallMap& a, const WallMap& b, const WallSearchSteps& steps)
      : steps_(steps),
        b_(b),
        sketch_(every_fourth(b)),
        middle_a_(WallBox(a).middle()),
        middle_b_(WallBox(b).middle()),
        radius_a_(radius_m(a, middle_a_)),
        radius_b_(radius_m(b, middle_b_)),
        n_(size_for(radius_a_, radius_b_, steps.cell_m)),
        a_(n_) {
    ComplexGrid grid(n_ * n_);
    draw(a, middle_a_, 0, grid);
    ComplexGrid worth(n_ * n_);  // real: score of a wall of b that falls there; imaginary: of a free cell of b
    for (std::size_t y = 0; y < n_; ++y)
      for (std::size_t x = 0; x < n_; ++x) {
        const std::size_t i = y * n_ + x;
        worth.re[i] = smeared(grid.re, x, y) - steps.penalty * grid.im[i];
        worth.im[i] = -steps.penalty * grid.re[i];
      }
    Fft2(n_).forward(worth);
    take_apart(worth, n_, a_);
  }

  Eigen::Vector2d middle() const { return middle_b_.cast<double>(); }

  /// Of all placements that fall on the same cell of the cyclic grid, the best one (WallFit::lenient).
  WallMatch unfolded(const WallMatch& m, const WallField& field) const {
    const double side = static_cast<double>(n_) * static_cast<double>(steps_.cell_m);
    const Eigen::Vector2d from_middle = middle_at(m, middle()) - middle_a_.cast<double>();
    WallMatch best = m;
    int most = std::numeric_limits<int>::lowest();
    for (const double x : {-side, 0.0, side})
      for (const double y : {-side, 0.0, side}) {
        if ((from_middle + Eigen::Vector2d(x, y)).norm() > static_cast<double>(radius_a_ + radius_b_)) continue;
        const WallMatch moved{m.yaw_rad, m.shift_m + Eigen::Vector2d(x, y), m.score};
        const int worth = field.fit(sketch_, moved).lenient();
        if (worth <= most) continue;
        most = worth;
        best = moved;
      }
    return best;
  }

  /// Memory for one rotation after the other: to get it anew each time takes longer than to compute some of it.
  struct Scratch {
    explicit Scratch(const Correlator& of)
        : fft(of.n_), spectrum(of.n_ * of.n_), product(of.n_ * of.n_), b(of.n_), b_turned(of.n_) {}
    Fft2 fft;
    ComplexGrid spectrum, product;
    Spectrum b, b_turned;
  };

  /// Appends the best peaks for a rotation in the first quarter and for the three rotations at right angles to it.
  void search(std::size_t turn, Scratch& scratch, std::vector<WallMatch>& found) const {
    auto& [fft, spectrum, product, b, b_turned] = scratch;
    const double yaw = static_cast<double>(turn) * std::numbers::pi / 2 / static_cast<double>(steps_.quarter_turns);
    draw(b_, middle_b_, yaw, spectrum);
    fft.forward(spectrum);
    take_apart(spectrum, n_, b);
    headframe::turn(b, n_, b_turned);
    for (int quarters : {0, 2}) {
      correlate(a_, b, b_turned, quarters == 2, product);
      fft.inverse(product);
      add_peaks(product.re, yaw + quarters * std::numbers::pi / 2, found);
      add_peaks(product.im, yaw + (quarters + 1) * std::numbers::pi / 2, found);
    }
  }

 private:
  static std::size_t size_for(float radius_a, float radius_b, float cell_m) {
    const float span = std::max(2 * std::max(radius_a, radius_b), side_share * 2 * (radius_a + radius_b));
    return Fft2::size_for(static_cast<std::size_t>(span / cell_m) + 4);
  }
  std::size_t cyclic(float cells) const {
    const auto i = static_cast<std::ptrdiff_t>(std::lround(cells)), n = static_cast<std::ptrdiff_t>(n_);
    return static_cast<std::size_t>((i % n + n) % n);
  }

  /// Real: how much wall a cell holds, 0 to 1; imaginary: how much free ground.
  void draw(const WallMap& map, const Eigen::Vector2f& middle, double yaw, ComplexGrid& grid) const {
    std::fill(grid.re.begin(), grid.re.end(), 0.0F);
    std::fill(grid.im.begin(), grid.im.end(), 0.0F);
    const Eigen::Matrix2f turn = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix() / steps_.cell_m;
    const float share = map.cell_m / steps_.cell_m;
    const auto add = [&](const Eigen::Vector2f& p, Floats& to, float value) {
      const Eigen::Vector2f c = turn * (p - middle);
      float& cell = to[cyclic(c.y()) * n_ + cyclic(c.x())];
      cell = std::min(1.0F, cell + value);
    };
    for (const auto& p : map.walls) add(p, grid.re, 2 * share);
    for (const auto& p : map.free) add(p, grid.im, share * share);
  }

  float smeared(const Floats& grid, std::size_t x, std::size_t y) const {
    float sum = 0;
    for (std::size_t dy : {n_ - 1, n_, n_ + 1})
      for (std::size_t dx : {n_ - 1, n_, n_ + 1})
        sum += grid[(y + dy) % n_ * n_ + (x + dx) % n_] * (dy == n_ ? 0.5F : 0.25F) * (dx == n_ ? 2 : 1);
    return std::min(1.0F, sum);
  }

  void add_peaks(const Floats& scores, double yaw, std::vector<WallMatch>& found) const {
    std::vector<std::pair<float, std::size_t>> peaks;  // the negative score, and the cell
    std::vector<std::uint8_t> peak(n_);
    float least = 0;
    for (std::size_t y = 0; y < n_; ++y) {
      const float *row = &scores[y * n_], *up = &scores[(y + n_ - 1) % n_ * n_], *down = &scores[(y + 1) % n_ * n_];
      mark_peaks(row, up, down, n_, least, peak.data());
      for (std::size_t x = next_set(peak, 0); x < n_; x = next_set(peak, x + 1))
        peaks.emplace_back(-row[x], y * n_ + x);
      if (peaks.size() < 4 * steps_.peaks) continue;
      keep_least(peaks, steps_.peaks);
      least = -std::max_element(peaks.begin(), peaks.end())->first;
    }
    keep_least(peaks, steps_.peaks);
    std::sort(peaks.begin(), peaks.end());
    const auto scale = static_cast<float>(n_ * n_);
    for (const auto& [negative, i] : peaks) found.push_back(match_at(i, yaw, -negative / scale));
  }

  WallMatch match_at(std::size_t i, double yaw, float score) const {
    const auto signed_cell = [&](std::size_t c) {
      return static_cast<double>(c) - (c >= n_ / 2 ? static_cast<double>(n_) : 0);
    };
    const Eigen::Vector2d at = middle_a_.cast<double>() + static_cast<double>(steps_.cell_m) *
                                                              Eigen::Vector2d(signed_cell(i % n_), signed_cell(i / n_));
    return {wrap_rad(yaw), at - Eigen::Rotation2Dd(yaw) * middle(), score};
  }

  const WallSearchSteps steps_;
  const WallMap& b_;
  WallMap sketch_;  // every fourth cell of b
  Eigen::Vector2f middle_a_, middle_b_;
  float radius_a_, radius_b_;
  std::size_t n_;
  Spectrum a_;  // what a wall, and what a free cell of b scores there
};

}  // namespace

std::vector<WallMatch> search_walls(const WallMap& a, const WallField& field, const WallMap& b, std::size_t most,
                                    const WallSearchSteps& steps, int threads) {
  if (a.walls.empty() || b.walls.empty()) return {};
  const WallMap clear_a = clear_of_walls(a), clear_b = clear_of_walls(b);
  const Correlator correlator(clear_a, clear_b, steps);
  std::vector<std::vector<WallMatch>> found(steps.quarter_turns);
  for_blocks(steps.quarter_turns, 3, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    Correlator::Scratch scratch(correlator);
    for (std::size_t turn = begin; turn < end; ++turn) correlator.search(turn, scratch, found[turn]);
  });
  std::vector<WallMatch> matches = best_distinct(found, most, correlator.middle());
  for_blocks(matches.size(), 16, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) matches[i] = correlator.unfolded(matches[i], field);
  });
  return matches;
}

}  // namespace headframe
