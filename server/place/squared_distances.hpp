#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace headframe {

/// Vectors of one length, sixteen side by side, so that they are compared with a query sixteen at a time.
class PanelStore {
 public:
  static constexpr std::size_t width = 16;

  explicit PanelStore(std::size_t length) : length_(length) {}

  void add(std::span<const float> vector);
  std::size_t size() const { return size_; }
  std::size_t panels() const { return (size_ + width - 1) / width; }

  /// Squared distances of `queries` from all vectors, panels() * width for each query, one query after another. Beyond
  /// size() they are huge. Each is exact to 2 * length float roundings of the two squared lengths' sum (rounding_of()):
  /// the processor's widest instructions are used.
  void distances(std::span<const std::span<const float>> queries, std::vector<float>& out) const;

  /// At most so much is one distance of this query off.
  float rounding_of(std::span<const float> query) const;

  /// The squared distance from vector i, the same on every processor.
  float distance(std::size_t i, std::span<const float> query) const;

 private:
  std::size_t length_;
  std::size_t size_ = 0;
  std::size_t used_ = 0;                // beyond so many numbers all vectors are zero
  float greatest_ = 0;                  // of the squared lengths
  std::vector<float> squared_lengths_;  // of each vector
  std::vector<float> values_;           // panel by panel; in each, for every dimension, sixteen vectors' values
};

}  // namespace headframe
