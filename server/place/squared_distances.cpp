#include "server/place/squared_distances.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace headframe {
namespace {

constexpr std::size_t width = PanelStore::width;
constexpr std::size_t together = 6;  // queries: as many sums as fit into the registers
constexpr float far_away = 1e30F;    // squared length of the vectors that fill up the last panel

// The compiler's own vector types (GCC, clang). The unaligned ones are for loading from memory.
struct Four {
  using Vector = float __attribute__((vector_size(16)));
  using InMemory = float __attribute__((vector_size(16), aligned(4), may_alias));
};
struct Eight {
  using Vector = float __attribute__((vector_size(32)));
  using InMemory = float __attribute__((vector_size(32), aligned(4), may_alias));
};

float squared_length(std::span<const float> vector) {
  float sum = 0;
  for (const float v : vector) sum += v * v;
  return sum;
}

using Queries = std::array<const float*, together>;

/// The stored data: panels of vectors, and the squared length of each vector.
struct Panels {
  const float *values, *squared_lengths;
  std::size_t panels, length;
  std::size_t used;  // used length of each vector; beyond, all are zero
};

/// The distances of the first `count` queries from all panels as |a|^2 + |q|^2 - 2 a.q, which needs one operation per
/// number instead of two.
template <class Lanes, std::size_t count>
[[gnu::always_inline]] inline void compare(const Panels& all, const Queries& queries,
                                           const std::array<float, together>& squared_lengths, float* out) {
  using Vector = typename Lanes::Vector;
  using InMemory = typename Lanes::InMemory;
  constexpr std::size_t lanes = sizeof(Vector) / sizeof(float), parts = width / lanes;
  for (std::size_t p = 0; p < all.panels; ++p) {
    const float* values = all.values + p * all.length * width;
    Vector sums[count][parts] = {};
    for (std::size_t d = 0; d < all.used; ++d, values += width) {
      Vector row[parts];
      for (std::size_t k = 0; k < parts; ++k) row[k] = *reinterpret_cast<const InMemory*>(values + lanes * k);
      for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < parts; ++k) sums[j][k] += row[k] * queries[j][d];
    }
    for (std::size_t k = 0; k < parts; ++k) {
      const Vector squared = *reinterpret_cast<const InMemory*>(all.squared_lengths + p * width + lanes * k);
      for (std::size_t j = 0; j < count; ++j)
        *reinterpret_cast<InMemory*>(out + (j * all.panels + p) * width + lanes * k) =
            squared + squared_lengths[j] - 2 * sums[j][k];
    }
  }
}

using Compare = void (*)(const Panels&, const Queries&, const std::array<float, together>&, float*);

template <std::size_t count>
void compare_anywhere(const Panels& all, const Queries& queries, const std::array<float, together>& squared_lengths,
                      float* out) {
  compare<Four, count>(all, queries, squared_lengths, out);
}

#if defined(__x86_64__)
template <std::size_t count>
[[gnu::target("avx2,fma")]] void compare_avx2(const Panels& all, const Queries& queries,
                                              const std::array<float, together>& squared_lengths, float* out) {
  compare<Eight, count>(all, queries, squared_lengths, out);
}
#endif

template <std::size_t count>
Compare best_compare() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return compare_avx2<count>;
#endif
  return compare_anywhere<count>;
}

}  // namespace

void PanelStore::add(std::span<const float> vector) {
  if (size_ % width == 0) {
    values_.resize(values_.size() + length_ * width, 0);
    squared_lengths_.resize(squared_lengths_.size() + width, far_away);
  }
  float* panel = values_.data() + size_ / width * length_ * width;
  for (std::size_t d = 0; d < length_; ++d) {
    panel[d * width + size_ % width] = vector[d];
    if (vector[d] != 0) used_ = std::max(used_, d + 1);
  }
  squared_lengths_[size_] = squared_length(vector);
  greatest_ = std::max(greatest_, squared_lengths_[size_]);
  ++size_;
}

void PanelStore::distances(std::span<const std::span<const float>> queries, std::vector<float>& out) const {
  static const Compare many = best_compare<together>(), one = best_compare<1>();
  const Panels all{values_.data(), squared_lengths_.data(), panels(), length_, used_};
  const std::size_t row = panels() * width;
  out.resize(queries.size() * row);
  for (std::size_t i = 0; i < queries.size();) {
    const std::size_t taken = queries.size() - i >= together ? together : 1;
    Queries now{};
    std::array<float, together> squared_lengths{};
    for (std::size_t j = 0; j < taken; ++j) {
      now[j] = queries[i + j].data();
      squared_lengths[j] = squared_length(queries[i + j]);
    }
    (taken == together ? many : one)(all, now, squared_lengths, out.data() + i * row);
    i += taken;
  }
}

float PanelStore::rounding_of(std::span<const float> query) const {
  return 2 * static_cast<float>(length_) * std::numeric_limits<float>::epsilon() * (squared_length(query) + greatest_);
}

float PanelStore::distance(std::size_t i, std::span<const float> query) const {
  const float* value = values_.data() + i / width * length_ * width + i % width;
  float sum = 0;
  for (std::size_t d = 0; d < length_; ++d, value += width) sum += (*value - query[d]) * (*value - query[d]);
  return sum;
}

}  // namespace headframe
