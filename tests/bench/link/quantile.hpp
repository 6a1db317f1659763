#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace headframe::bench {

/// Of sorted or unsorted values; 0 of none.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(q * static_cast<double>(values.size() - 1)))];
}

}  // namespace headframe::bench
