#include "tests/mine/noise.hpp"

#include <cmath>

namespace headframe::mine {
namespace {

double corner_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
  std::uint64_t h = seed + static_cast<std::uint64_t>(x) * 0x8da6b343ULL +
                    static_cast<std::uint64_t>(y) * 0xd8163841ULL + static_cast<std::uint64_t>(z) * 0xcb1ab31fULL;
  h = (h ^ (h >> 29)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 32)) * 0x94d049bb133111ebULL;
  return static_cast<double>(h >> 40) * (2.0 / 16777216.0) - 1.0;
}

double fade(double t) { return t * t * (3.0 - 2.0 * t); }
double lerp(double a, double b, double t) { return a + (b - a) * t; }

}  // namespace

double noise_at(const Eigen::Vector3d& p, double scale_m, std::uint64_t seed) {
  const Eigen::Vector3d q = p / scale_m;
  const Eigen::Vector3d base(std::floor(q.x()), std::floor(q.y()), std::floor(q.z()));
  const double tx = fade(q.x() - base.x()), ty = fade(q.y() - base.y()), tz = fade(q.z() - base.z());
  const auto x = static_cast<std::int64_t>(base.x()), y = static_cast<std::int64_t>(base.y()),
             z = static_cast<std::int64_t>(base.z());
  const auto edge = [&](std::int64_t dy, std::int64_t dz) {
    return lerp(corner_value(x, y + dy, z + dz, seed), corner_value(x + 1, y + dy, z + dz, seed), tx);
  };
  return lerp(lerp(edge(0, 0), edge(1, 0), ty), lerp(edge(0, 1), edge(1, 1), ty), tz);
}

}  // namespace headframe::mine
