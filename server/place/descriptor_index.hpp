#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/session/ids.hpp"

namespace headframe {

struct PlaceNeighbour {
  KeyframeRef keyframe;
  float squared_distance = 0;
};

/// Nearest place vectors of one descriptor family. Not thread safe. All q must have the length given at construction.
class DescriptorIndex {
 public:
  virtual ~DescriptorIndex() = default;
  virtual void add(const KeyframeRef& keyframe, const std::vector<float>& q) = 0;
  /// The k nearest, nearest first; of equally near ones, the one added earlier comes first.
  virtual std::vector<PlaceNeighbour> nearest(const std::vector<float>& q, std::size_t k) const = 0;
  /// nearest() for many vectors, on this number of threads; the result does not depend on it.
  virtual std::vector<std::vector<PlaceNeighbour>> nearest_of_each(std::span<const std::span<const float>> qs,
                                                                   std::size_t k, int threads) const = 0;
  virtual std::size_t size() const = 0;
};

/// Compares with every vector. Serves as the reference in tests; faster than a tree up to about ten thousand keyframes.
std::unique_ptr<DescriptorIndex> make_exact_index(std::size_t q_size);

/// FLANN's randomised k-d trees (4 trees, 256 checks, fixed seed), rebuilt as the index doubles. For large databases.
std::unique_ptr<DescriptorIndex> make_flann_index(std::size_t q_size);

}  // namespace headframe
