#include "server/verification/sight_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr float radians_per_bin = std::numbers::pi_v<float> / 90;

// Without branches and calls, so that loops over many points are vectorised.

/// To 1.4e-4 rad: a fit of atan(t) / t for |t| <= 1 by a cubic in t^2.
[[gnu::always_inline]] inline float quick_atan2(float y, float x) {
  const float high = std::max(std::abs(x), std::abs(y)), low = std::min(std::abs(x), std::abs(y));
  const float quotient = low / high, t = high > 0 ? quotient : 0, s = t * t;
  const float flat = t * (0.9997528F + s * (-0.3252305F + s * (0.1540952F + s * -0.04335934F)));
  const float complement = std::numbers::pi_v<float> / 2 - flat;
  const float ahead = std::abs(y) > std::abs(x) ? complement : flat;
  const float supplement = std::numbers::pi_v<float> - ahead;
  const float angle = x < 0 ? supplement : ahead;
  return y < 0 ? -angle : angle;
}

[[gnu::always_inline]] inline int floored(float v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(v < static_cast<float>(i));
}

[[gnu::always_inline]] inline int column_of(float x, float y) {
  return floored(quick_atan2(y, x) / radians_per_bin) + SightImage::columns / 2;
}

[[gnu::always_inline]] inline int row_of(float across, float z) {
  return floored(quick_atan2(z, across) / radians_per_bin + SightImage::rows / 2.0F);
}

/// Of all points of a block.
struct Directions {
  std::array<float, SightBlock::most> range;
  std::array<int, SightBlock::most> column, row;
};

/// What the bins in their directions hold, in cm; near is 0 where there is no return.
struct Ranges {
  std::array<int, SightBlock::most> near, far, nearest, farthest;
};

HEADFRAME_WIDE void find_directions(const SightBlock& points, Directions& out) {
  const float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  std::array<float, SightBlock::most> across;
  for (std::size_t i = 0; i < points.count; ++i) {
    across[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    out.range[i] = std::sqrt(x[i] * x[i] + (y[i] * y[i] + z[i] * z[i]));
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    out.column[i] = column_of(x[i], y[i]);
    out.row[i] = row_of(across[i], z[i]);
  }
}

std::size_t index_of(int row, int column) {
  constexpr int n = SightImage::columns;
  return static_cast<std::size_t>(row) * n + static_cast<std::size_t>((column + n) % n);
}

/// The tolerance within which a point lies on a surface.
[[gnu::always_inline]] inline float tolerance_m(float range) { return 0.35F + 0.03F * range; }

constexpr int doubtful = 3;  // beside the values of Sight

/// What the bins ahead say, without branches; doubtful where the bins around them have to be asked.
HEADFRAME_WIDE void read_bins(const Directions& to, const Ranges& ahead, std::size_t count, float slack_m,
                              int* answers) {
  for (std::size_t i = 0; i < count; ++i) {
    const float range = to.range[i], tolerance = tolerance_m(range) + slack_m;
    const auto metres = [](int cm) { return 0.01F * static_cast<float>(cm); };
    const int through = static_cast<int>(range < metres(ahead.nearest[i]) - tolerance),
              hidden = static_cast<int>(range >= metres(ahead.farthest[i]) + tolerance),
              meets = static_cast<int>(std::abs(range - metres(ahead.near[i])) < tolerance) |
                      static_cast<int>(std::abs(range - metres(ahead.far[i])) < tolerance);
    const int in_reach = meets != 0 ? static_cast<int>(Sight::hit) : doubtful,
              not_through = hidden != 0 ? static_cast<int>(Sight::unknown) : in_reach,
              known = through != 0 ? static_cast<int>(Sight::through) : not_through;
    answers[i] = ahead.near[i] == 0 ? static_cast<int>(Sight::unknown) : known;
  }
}

}  // namespace

SightImage::SightImage(const Points& points) {
  std::vector<Bin> all(static_cast<std::size_t>(columns) * rows);
  first_row_ = rows;
  for (const auto& p : points) {
    const float range = p.norm();
    if (!(range > 0.1F)) continue;
    const Direction d = direction(p.x(), p.y(), p.z());
    if (d.row < 0 || d.row >= rows) continue;
    Bin& bin = all[index_of(d.row, d.column)];
    const auto range_cm = static_cast<std::uint16_t>(std::min(range * 100, 65535.0F));
    bin.near_cm = bin.near_cm > 0 ? std::min(bin.near_cm, range_cm) : range_cm;
    bin.far_cm = std::max(bin.far_cm, range_cm);
    first_row_ = std::min(first_row_, d.row);
    end_row_ = std::max(end_row_, d.row + 1);
  }
  if (end_row_ > 0) bins_.assign(all.begin() + first_row_ * columns, all.begin() + end_row_ * columns);
  bins_.emplace_back();
  for (int row = first_row_; row < end_row_; ++row)
    for (int column = 0; column < columns; ++column) sum_up(row, column);
}

const SightImage::Bin& SightImage::bin(int row, int column) const { return bins_[index_of(row - first_row_, column)]; }

void SightImage::sum_up(int row, int column) {
  Bin& sum = bins_[index_of(row - first_row_, column)];
  sum.nearest_cm = std::numeric_limits<std::uint16_t>::max();
  for (int r = std::max(first_row_, row - 1); r <= std::min(end_row_ - 1, row + 1); ++r)
    for (int step = -1; step <= 1; ++step) {
      const Bin& other = bin(r, column + step);
      if (other.near_cm == 0) continue;
      sum.nearest_cm = std::min(sum.nearest_cm, other.near_cm);
      sum.farthest_cm = std::max(sum.farthest_cm, other.far_cm);
    }
}

SightImage::Direction SightImage::direction(float x, float y, float z) {
  return {column_of(x, y), row_of(std::sqrt(x * x + y * y), z)};
}

Sight SightImage::look(const Eigen::Vector3f& point, float reach_m, float slack_m) const {
  SightBlock block;
  block.add(point);
  std::array<Sight, SightBlock::most> answers;
  look(block, reach_m, answers, slack_m);
  return answers[0];
}

/// Which way a comparison goes can hardly be predicted, so branches are left to the few points in doubt.
void SightImage::look(const SightBlock& points, float reach_m, std::span<Sight, SightBlock::most> answers,
                      float slack_m) const {
  Directions to;
  find_directions(points, to);
  Ranges ahead;
  for (std::size_t i = 0; i < points.count; ++i) {
    const int in_reach = static_cast<int>(to.range[i] <= reach_m) & static_cast<int>(to.range[i] >= 0.5F),
              in_view = static_cast<int>(to.row[i] >= first_row_) & static_cast<int>(to.row[i] < end_row_);
    const Bin& bin =
        bins_[(in_reach & in_view) != 0 ? index_of(to.row[i] - first_row_, to.column[i]) : bins_.size() - 1];
    ahead.near[i] = bin.near_cm;
    ahead.far[i] = bin.far_cm;
    ahead.nearest[i] = bin.nearest_cm;
    ahead.farthest[i] = bin.farthest_cm;
  }
  std::array<int, SightBlock::most> known;
  read_bins(to, ahead, points.count, slack_m, known.data());
  std::array<std::uint8_t, SightBlock::most> in_doubt;
  std::size_t doubts = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    answers[i] = static_cast<Sight>(known[i]);
    in_doubt[doubts] = static_cast<std::uint8_t>(i);
    doubts += static_cast<std::size_t>(known[i] == doubtful);
  }
  for (const std::uint8_t i : std::span(in_doubt).first(doubts)) {
    const float tolerance = tolerance_m(to.range[i]) + slack_m;
    answers[i] = meets_around(to.row[i], to.column[i], to.range[i], tolerance) ? Sight::hit : Sight::unknown;
  }
}

/// A surface seen at a flat angle has very different ranges in neighbouring bins.
bool SightImage::meets_around(int at_row, int at_column, float range, float tolerance) const {
  // The ranges between the nearest and the farthest of a bin belong to a slanted wall, or to dust and the wall behind
  // it.
  const auto meets = [&](const Bin& b) {
    return b.near_cm > 0 &&
           (std::abs(range - 0.01F * b.near_cm) < tolerance || std::abs(range - 0.01F * b.far_cm) < tolerance);
  };
  for (int row = std::max(first_row_, at_row - 1); row <= std::min(end_row_ - 1, at_row + 1); ++row)
    for (int step = -1; step <= 1; ++step)
      if (meets(bin(row, at_column + step))) return true;
  return false;
}

}  // namespace headframe
