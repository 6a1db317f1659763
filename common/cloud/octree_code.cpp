#include "common/cloud/octree_code.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr int small_levels = 5;  // a cube of 32 cells: smaller than the distance between most points

}  // namespace

void OctreeEncoder::put_cube(std::span<const std::uint64_t> codes, int levels, std::size_t siblings) {
  if (levels == 0) {
    for (std::size_t i = 1; i < codes.size(); ++i) coder_.put(model_.repeated, true);
    return coder_.put(model_.repeated, false);
  }
  const auto level = static_cast<std::size_t>(levels);
  if (levels <= small_levels) {
    const bool alone = codes.size() == 1;
    coder_.put(model_.alone[level][siblings], alone);
    if (alone) return coder_.put_plain(codes.front(), 3 * levels);
  }
  const int shift = 3 * (levels - 1);
  std::array<std::span<const std::uint64_t>, 8> children;
  std::size_t pattern = 1, count = 0;
  for (std::size_t child = 0; child < 8; ++child) {
    const auto end = std::partition_point(codes.begin(), codes.end(),
                                          [&](std::uint64_t code) { return (code >> shift & 7U) <= child; });
    children[child] = {codes.begin(), end};
    codes = {end, codes.end()};
    const bool occupied = !children[child].empty();
    if (child < 7 || count > 0) coder_.put(model_.occupied[level][pattern], occupied);
    pattern = pattern << 1 | (occupied ? 1U : 0U);
    count += occupied ? 1 : 0;
  }
  for (const auto& child : children)
    if (!child.empty()) put_cube(child, levels - 1, count);
}

bool OctreeDecoder::get(std::size_t points, int levels, std::vector<std::uint64_t>& codes) {
  codes.clear();
  codes_ = &codes;
  wanted_ = points;
  return get_cube(0, levels, 0) && codes.size() == points;
}

bool OctreeDecoder::get_cube(std::uint64_t prefix, int levels, std::size_t siblings) {
  if (codes_->size() == wanted_ || coder_.overrun()) return false;
  if (levels == 0) {
    do codes_->push_back(prefix);
    while (coder_.get(model_.repeated) && codes_->size() < wanted_);
    return true;
  }
  const auto level = static_cast<std::size_t>(levels);
  if (levels <= small_levels && coder_.get(model_.alone[level][siblings])) {
    codes_->push_back(prefix << 3 * levels | coder_.get_plain(3 * levels));
    return true;
  }
  std::size_t pattern = 1, count = 0;
  for (std::size_t child = 0; child < 8; ++child) {
    const bool occupied = (child == 7 && count == 0) || coder_.get(model_.occupied[level][pattern]);
    pattern = pattern << 1 | (occupied ? 1U : 0U);
    count += occupied ? 1 : 0;
  }
  for (std::uint64_t child = 0; child < 8; ++child)
    if ((pattern >> (7 - child) & 1U) != 0 && !get_cube(prefix << 3 | child, levels - 1, count)) return false;
  return true;
}

}  // namespace headframe
