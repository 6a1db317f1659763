#include "server/place/squared_distances.hpp"

#include <algorithm>
#include <array>

namespace headframe {
namespace {

constexpr std::size_t width = PanelStore::width;
constexpr std::size_t together = 6;  // queries: as many sums as there are registers for
constexpr float far_away = 1e18F;    // squared it is still finite

// The compiler's own vectors (GCC, clang). Unaligned ones are for memory.
struct Four {
  using Vector = float __attribute__((vector_size(16)));
  using InMemory = float __attribute__((vector_size(16), aligned(4), may_alias));
};
struct Eight {
  using Vector = float __attribute__((vector_size(32)));
  using InMemory = float __attribute__((vector_size(32), aligned(4), may_alias));
};

using Queries = std::array<const float*, together>;

/// Of the first `count` queries from all panels.
template <class Lanes, std::size_t count>
[[gnu::always_inline]] inline void compare(const float* values, std::size_t panels, std::size_t length,
                                           const Queries& queries, float* out) {
  using Vector = typename Lanes::Vector;
  using InMemory = typename Lanes::InMemory;
  constexpr std::size_t lanes = sizeof(Vector) / sizeof(float), parts = width / lanes;
  for (std::size_t p = 0; p < panels; ++p) {
    Vector sums[count][parts] = {};
    for (std::size_t d = 0; d < length; ++d, values += width) {
      Vector row[parts];
      for (std::size_t k = 0; k < parts; ++k) row[k] = *reinterpret_cast<const InMemory*>(values + lanes * k);
      for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < parts; ++k) {
          const Vector apart = row[k] - queries[j][d];
          sums[j][k] += apart * apart;
        }
    }
    for (std::size_t j = 0; j < count; ++j)
      for (std::size_t k = 0; k < parts; ++k)
        *reinterpret_cast<InMemory*>(out + (j * panels + p) * width + lanes * k) = sums[j][k];
  }
}

using Compare = void (*)(const float*, std::size_t, std::size_t, const Queries&, float*);

template <std::size_t count>
void compare_anywhere(const float* values, std::size_t panels, std::size_t length, const Queries& queries, float* out) {
  compare<Four, count>(values, panels, length, queries, out);
}

#if defined(__x86_64__)
template <std::size_t count>
[[gnu::target("avx2,fma")]] void compare_avx2(const float* values, std::size_t panels, std::size_t length,
                                              const Queries& queries, float* out) {
  compare<Eight, count>(values, panels, length, queries, out);
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
  if (size_ % width == 0) values_.resize(values_.size() + length_ * width, far_away);
  float* panel = values_.data() + size_ / width * length_ * width;
  for (std::size_t d = 0; d < length_; ++d) panel[d * width + size_ % width] = vector[d];
  ++size_;
}

void PanelStore::distances(std::span<const std::span<const float>> queries, std::vector<float>& out) const {
  static const Compare many = best_compare<together>(), one = best_compare<1>();
  const std::size_t row = panels() * width;
  out.resize(queries.size() * row);
  for (std::size_t i = 0; i < queries.size();) {
    const std::size_t taken = queries.size() - i >= together ? together : 1;
    Queries now{};
    for (std::size_t j = 0; j < taken; ++j) now[j] = queries[i + j].data();
    (taken == together ? many : one)(values_.data(), panels(), length_, now, out.data() + i * row);
    i += taken;
  }
}

float PanelStore::distance(std::size_t i, std::span<const float> query) const {
  const float* value = values_.data() + i / width * length_ * width + i % width;
  float sum = 0;
  for (std::size_t d = 0; d < length_; ++d, value += width) sum += (*value - query[d]) * (*value - query[d]);
  return sum;
}

}  // namespace headframe
