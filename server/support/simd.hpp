#pragma once
// Vectors of four floats, using the compiler's own vector types (GCC, clang); the same results on every processor.

#include <cstdint>

namespace headframe {

using Float4 = float __attribute__((vector_size(16)));
using Mask4 = std::int32_t __attribute__((vector_size(16)));  // 0 or -1 in every lane

inline Float4 all_lanes(float v) { return Float4{v, v, v, v}; }
inline Float4 masked(Mask4 mask, Float4 v) { return reinterpret_cast<Float4>(reinterpret_cast<Mask4>(v) & mask); }
inline Float4 larger(Float4 a, Float4 b) { return a > b ? a : b; }
inline float sum_of_lanes(Float4 v) { return (v[0] + v[1]) + (v[2] + v[3]); }
inline int count_of_lanes(Mask4 ones) { return (ones[0] + ones[1]) + (ones[2] + ones[3]); }

inline bool any(Mask4 mask) {
  using Halves = std::int64_t __attribute__((vector_size(16)));
  const auto halves = reinterpret_cast<Halves>(mask);
  return (halves[0] | halves[1]) != 0;
}

}  // namespace headframe
