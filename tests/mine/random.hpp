#pragma once
// Random numbers that are the same on every machine, with streams that do not disturb each other.

#include <cmath>
#include <cstdint>
#include <numbers>

namespace headframe::mine {

/// Mixes all bits (the finaliser of a 64-bit hash); 0 does not stay 0 for different salts.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// A small generator. Not thread safe; give each thread its own fork.
class Rng {
 public:
  explicit Rng(std::uint64_t seed) : state_(mix_bits(seed)) {}

  /// An independent stream: the same salt gives the same stream however many numbers were drawn here.
  Rng fork(std::uint64_t salt) const { return Rng(seed_of(salt)); }

  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In [0, n); n > 0.
  std::size_t index(std::size_t n) { return static_cast<std::size_t>(next() % n); }
  bool chance(double probability) { return uniform() < probability; }

  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t next() { return mix_bits(state_ + 0x632be59bd9b4e019ULL * ++count_); }
  std::uint64_t seed_of(std::uint64_t salt) const { return mix_bits(state_ ^ mix_bits(salt + 1)); }

  std::uint64_t state_;
  std::uint64_t count_ = 0;
};

}  // namespace headframe::mine
