#include "server/place/wall_map.hpp"

#include <kissfft/kiss_fftnd.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <unordered_map>

#include "common/descriptor/wall_profile.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr float wall_reach_m = 30;
constexpr float free_reach_m = 20;
constexpr float penalty = 3;
constexpr int turns = 180;
constexpr std::size_t peaks_per_turn = 12;
constexpr double same_place_m = 5, same_yaw_rad = 20 * std::numbers::pi / 180;

using Complex = std::complex<float>;
static_assert(sizeof(Complex) == sizeof(kiss_fft_cpx));

class Fft2 {
 public:
  Fft2(int rows, int columns, bool inverse) {
    const int dims[2] = {rows, columns};
    plan_.reset(kiss_fftnd_alloc(dims, 2, inverse ? 1 : 0, nullptr, nullptr));
  }
  void run(const std::vector<Complex>& in, std::vector<Complex>& out) const {
    kiss_fftnd(plan_.get(), reinterpret_cast<const kiss_fft_cpx*>(in.data()), reinterpret_cast<kiss_fft_cpx*>(out.data()));
  }

 private:
  struct Free {
    void operator()(kiss_fftnd_cfg p) const { kiss_fft_free(p); }
  };
  std::unique_ptr<std::remove_pointer_t<kiss_fftnd_cfg>, Free> plan_;
};

struct Box {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9F), high = Eigen::Vector2f::Constant(-1e9F);
  void add(const std::vector<Eigen::Vector2f>& points) {
    for (const auto& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
};

/// A dense drawing of map a: for a wall of b, and for a free cell of b, what each place is worth.
struct Drawing {
  int rows = 0, columns = 0;
  Eigen::Vector2f low;
  float cell_m = 0;
  std::vector<float> for_wall, for_free;

  Drawing(const WallMap& map, int rows_, int columns_, const Eigen::Vector2f& low_)
      : rows(rows_), columns(columns_), low(low_), cell_m(map.cell_m) {
    for_wall.assign(static_cast<std::size_t>(rows) * columns, 0);
    for_free = for_wall;
    for (const auto& p : map.free) set(for_wall, p, 0, 0, -penalty);
    for (const auto& p : map.walls)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) set(for_wall, p, dx, dy, 1);
    for (const auto& p : map.walls) set(for_free, p, 0, 0, -penalty);
  }
  int cell(float v, int axis) const { return static_cast<int>(std::floor((v - low[axis]) / cell_m)); }
  void set(std::vector<float>& grid, const Eigen::Vector2f& p, int dx, int dy, float value) {
    const int x = cell(p.x(), 0) + dx, y = cell(p.y(), 1) + dy;
    if (x >= 0 && y >= 0 && x < columns && y < rows) grid[static_cast<std::size_t>(y) * columns + x] = value;
  }
  float at(const std::vector<float>& grid, const Eigen::Vector2f& p) const {
    const int x = cell(p.x(), 0), y = cell(p.y(), 1);
    return x >= 0 && y >= 0 && x < columns && y < rows ? grid[static_cast<std::size_t>(y) * columns + x] : 0;
  }
};

double score_at(const Drawing& a, const WallMap& b, const WallMatch& m) {
  const Eigen::Rotation2Df R(static_cast<float>(m.yaw_rad));
  const Eigen::Matrix2f turn = R.toRotationMatrix();
  const Eigen::Vector2f shift = m.shift_m.cast<float>();
  double score = 0;
  for (const auto& p : b.walls) score += a.at(a.for_wall, turn * p + shift);
  for (const auto& p : b.free) score += a.at(a.for_free, turn * p + shift);
  return score;
}

WallMatch refine(const Drawing& a, const WallMap& b, WallMatch best) {
  const double step = a.cell_m / 2;
  const WallMatch start = best;
  best.score = -1e18;
  for (int turn = -2; turn <= 2; ++turn)
    for (int y = -2; y <= 2; ++y)
      for (int x = -2; x <= 2; ++x) {
        WallMatch m = start;
        m.yaw_rad = start.yaw_rad + turn * std::numbers::pi / 180;
        m.shift_m += Eigen::Vector2d(x, y) * step;
        m.score = score_at(a, b, m);
        if (m.score > best.score) best = m;
      }
  return best;
}

/// Two placements of b are the same when they move b's middle to the same place and turn it alike.
bool same(const WallMatch& m, const WallMatch& n, const Eigen::Vector2d& middle) {
  const auto at = [&](const WallMatch& k) -> Eigen::Vector2d {
    return Eigen::Rotation2Dd(k.yaw_rad) * middle + k.shift_m;
  };
  return (at(m) - at(n)).norm() < same_place_m &&
         std::abs(std::remainder(m.yaw_rad - n.yaw_rad, 2 * std::numbers::pi)) < same_yaw_rad;
}

void keep_distinct(std::vector<WallMatch>& matches, std::size_t most, const Eigen::Vector2d& middle) {
  std::stable_sort(matches.begin(), matches.end(), [](const auto& m, const auto& n) { return m.score > n.score; });
  std::vector<WallMatch> kept;
  for (const WallMatch& m : matches) {
    if (kept.size() == most) break;
    if (std::none_of(kept.begin(), kept.end(), [&](const WallMatch& k) { return same(k, m, middle); })) kept.push_back(m);
  }
  matches = std::move(kept);
}

}  // namespace

WallMap draw_wall_map(std::span<const Keyframe> keyframes, float cell_m) {
  struct Cell {
    int wall = 0, free = 0;
  };
  std::unordered_map<std::uint64_t, std::size_t> index;
  std::vector<std::pair<Eigen::Vector2i, Cell>> cells;
  const auto cell_at = [&](const Eigen::Vector2f& p) -> Cell& {
    const Eigen::Vector2i c = (p / cell_m).array().floor().cast<int>();
    const auto key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(c.x())) << 32 | static_cast<std::uint32_t>(c.y());
    const auto [it, fresh] = index.try_emplace(key, cells.size());
    if (fresh) cells.emplace_back(c, Cell{});
    return cells[it->second].second;
  };
  for (const Keyframe& keyframe : keyframes) {
    const Eigen::Vector2f origin = keyframe.T_local_sensor.translation().head<2>().cast<float>();
    const double yaw = yaw_rad(keyframe.T_local_sensor);
    for (std::size_t i = 0; i < WallProfile::sectors; ++i) {
      const float range = decode_wall_range_m(keyframe.walls.code[i]);
      if (range == 0) continue;
      const double azimuth = yaw + (static_cast<double>(i) + 0.5) * 2 * std::numbers::pi / WallProfile::sectors;
      const Eigen::Vector2f ray(static_cast<float>(std::cos(azimuth)), static_cast<float>(std::sin(azimuth)));
      for (float r = 0.5F * cell_m; r < std::min(range - cell_m, free_reach_m); r += cell_m) ++cell_at(origin + r * ray).free;
      if (range < wall_reach_m) ++cell_at(origin + range * ray).wall;
    }
  }
  WallMap map;
  map.cell_m = cell_m;
  for (const auto& [c, cell] : cells) {
    const Eigen::Vector2f centre = (c.cast<float>().array() + 0.5F) * cell_m;
    if (cell.wall > 0 && 2 * cell.wall >= cell.free) map.walls.push_back(centre);
    else if (cell.free > 1) map.free.push_back(centre);
  }
  return map;
}

std::vector<WallMatch> correlate(const WallMap& a, const WallMap& b, std::size_t most, int threads) {
  if (a.walls.empty() || b.walls.empty()) return {};
  const float cell = a.cell_m;
  Box box_a, box_b;
  box_a.add(a.walls);
  box_a.add(a.free);
  box_b.add(b.walls);
  box_b.add(b.free);
  const Eigen::Vector2f middle_b = (box_b.low + box_b.high) / 2;
  float radius_b = 0;
  for (const auto* list : {&b.walls, &b.free})
    for (const auto& p : *list) radius_b = std::max(radius_b, (p - middle_b).norm());
  // b is drawn around its middle in a square of 2 radii; the sum of both sizes avoids wrapped-around overlaps.
  const int span_b = static_cast<int>(std::ceil(2 * radius_b / cell)) + 3;
  const auto size = [&](int axis) {
    return kiss_fft_next_fast_size(static_cast<int>(std::ceil((box_a.high[axis] - box_a.low[axis]) / cell)) + 3 + span_b);
  };
  const int columns = size(0), rows = size(1);
  const std::size_t n = static_cast<std::size_t>(rows) * columns;
  const Eigen::Vector2f low_a = box_a.low.array() - cell;
  const Drawing drawing(a, rows, columns, low_a);
  const Fft2 forward(rows, columns, false), backward(rows, columns, true);

  // Two real grids share a complex transform; A1 and A2 are taken apart again by symmetry.
  std::vector<Complex> packed(n), spectrum(n);
  for (std::size_t i = 0; i < n; ++i) packed[i] = {drawing.for_wall[i], drawing.for_free[i]};
  forward.run(packed, spectrum);
  const auto mirrored = [&](std::size_t i) {
    const std::size_t y = i / columns, x = i % columns;
    return (y == 0 ? 0 : rows - y) * columns + (x == 0 ? 0 : columns - x);
  };
  std::vector<Complex> A1(n), A2(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Complex s = spectrum[i], m = std::conj(spectrum[mirrored(i)]);
    A1[i] = 0.5F * (s + m);
    A2[i] = Complex(0, -0.5F) * (s - m);
  }

  std::vector<std::vector<WallMatch>> found(turns);
  for_blocks(turns, 10, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    std::vector<Complex> grid(n), B(n), product(n), score(n);
    const Fft2 forward_own(rows, columns, false), backward_own(rows, columns, true);  // plans hold scratch memory
    for (std::size_t t = begin; t < end; ++t) {
      const double yaw = static_cast<double>(t) * 2 * std::numbers::pi / turns;
      const Eigen::Matrix2f turn = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
      std::fill(grid.begin(), grid.end(), Complex());
      const auto cell_of = [&](const Eigen::Vector2f& p) {
        const Eigen::Vector2f c = (turn * (p - middle_b)) / cell;
        const int x = static_cast<int>(std::floor(c.x())) + span_b / 2, y = static_cast<int>(std::floor(c.y())) + span_b / 2;
        return static_cast<std::size_t>(std::clamp(y, 0, rows - 1)) * columns + static_cast<std::size_t>(std::clamp(x, 0, columns - 1));
      };
      for (const auto& p : b.walls) grid[cell_of(p)].real(1);
      for (const auto& p : b.free) grid[cell_of(p)].imag(1);
      forward_own.run(grid, B);
      for (std::size_t i = 0; i < n; ++i) {
        const Complex s = B[i], m = std::conj(B[mirrored(i)]);
        product[i] = A1[i] * std::conj(0.5F * (s + m)) + A2[i] * std::conj(Complex(0, -0.5F) * (s - m));
      }
      backward_own.run(product, score);

      std::vector<std::size_t> order(n);
      for (std::size_t i = 0; i < n; ++i) order[i] = i;
      const std::size_t wanted = std::min<std::size_t>(n, 400);
      std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(wanted), order.end(), [&](auto i, auto j) {
        return score[i].real() > score[j].real() || (score[i].real() == score[j].real() && i < j);
      });
      for (std::size_t k = 0; k < wanted; ++k) {
        int x = static_cast<int>(order[k] % columns), y = static_cast<int>(order[k] / columns);
        if (x > columns - span_b) x -= columns;
        if (y > rows - span_b) y -= rows;
        // Cell (x, y) shifts b's drawing, whose middle is at span_b / 2, onto a's.
        const Eigen::Vector2f middle_at = low_a + Eigen::Vector2f(static_cast<float>(x + span_b / 2), static_cast<float>(y + span_b / 2)) * cell;
        WallMatch m;
        m.yaw_rad = wrap_rad(yaw);
        m.shift_m = (middle_at - turn * middle_b).cast<double>();
        m.score = score[order[k]].real() / static_cast<double>(n);
        const Eigen::Vector2d middle = middle_b.cast<double>();
        if (found[t].size() < peaks_per_turn &&
            std::none_of(found[t].begin(), found[t].end(), [&](const WallMatch& f) { return same(f, m, middle); }))
          found[t].push_back(m);
      }
    }
  });
  std::vector<WallMatch> matches;
  for (const auto& list : found) matches.insert(matches.end(), list.begin(), list.end());
  keep_distinct(matches, 3 * most, middle_b.cast<double>());
  for (WallMatch& m : matches) m = refine(drawing, b, m);
  keep_distinct(matches, most, middle_b.cast<double>());
  return matches;
}

}  // namespace headframe
