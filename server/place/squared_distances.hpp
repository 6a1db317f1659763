#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace headframe {

/// Vectors of one length, stored in panels of sixteen, so that a query is compared with sixteen at a time.
class PanelStore {
 public:
  static constexpr std::size_t width = 16;

  explicit PanelStore(std::size_t length) : length_(length) {}

  void add(std::span<const float> vector);
  std::size_t size() const { return size_; }
  std::size_t panels() const { return (size_ + width - 1) / width; }

  /// Squared distances of `queries` from all vectors: panels() * width numbers for each query, one query after another.
  /// Numbers beyond size() are huge. Each is off by at most rounding_of() (2 * length float roundings of the sum of the
  /// two squared lengths), because it uses the processor's widest instructions.
  void distances(std::span<const std::span<const float>> queries, std::vector<float>& out) const;

  /// Upper bound of the error of a distance from this query.
  float rounding_of(std::span<const float> query) const;

  /// The squared distance from vector i, the same on every processor.
  float distance(std::size_t i, std::span<const float> query) const;

 private:
  std::size_t length_;
  std::size_t size_ = 0;
  std::size_t used_ = 0;                // all vectors are zero from this index on
  float greatest_ = 0;                  // greatest squared length
  std::vector<float> squared_lengths_;  // of each vector
  std::vector<float> values_;  // panel by panel; within a panel, for every dimension, the values of sixteen vectors
};

}  // namespace headframe
