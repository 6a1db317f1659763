#pragma once
// Encodes points of a grid as an octree, depth first: which of a cube's eight children hold points, each bit with the
// children before it and the cube's size as context. If a small cube holds only one point, its position in the cube is
// noise and is written without a model.

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "common/cloud/morton.hpp"
#include "common/cloud/range_coder.hpp"

namespace headframe {

/// Learned probabilities of occupancy; shared by the sweeps of one cloud.
struct OctreeModel {
  std::array<std::array<AdaptiveBit, 256>, morton::axis_bits + 1> occupied;  // [levels below][1 and the bits before]
  std::array<std::array<AdaptiveBit, 9>, morton::axis_bits + 1> alone;       // [levels below][siblings]
  AdaptiveBit repeated;
};

class OctreeEncoder {
 public:
  /// Sorted Morton codes below 8^levels, at least one; duplicates are allowed.
  void put(std::span<const std::uint64_t> codes, int levels) { put_cube(codes, levels, 0); }
  std::string finish() { return coder_.finish(); }

 private:
  void put_cube(std::span<const std::uint64_t> codes, int levels, std::size_t siblings);

  OctreeModel model_;
  RangeEncoder coder_;
};

/// Accepts any bytes; work and memory are bounded by the number of points requested.
class OctreeDecoder {
 public:
  explicit OctreeDecoder(std::string_view bytes) : coder_(bytes) {}

  /// Returns `points` codes in rising order; false: the bytes are not an encoder's.
  bool get(std::size_t points, int levels, std::vector<std::uint64_t>& codes);
  /// Whether exactly all bytes were read.
  bool done() const { return coder_.done(); }

 private:
  bool get_cube(std::uint64_t prefix, int levels, std::size_t siblings);

  OctreeModel model_;
  RangeDecoder coder_;
  std::vector<std::uint64_t>* codes_ = nullptr;
  std::size_t wanted_ = 0;
};

}  // namespace headframe
