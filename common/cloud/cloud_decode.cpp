#include <algorithm>
#include <cmath>
#include <optional>

#include "common/cloud/cloud_codec.hpp"
#include "common/cloud/cloud_form.hpp"
#include "common/cloud/cloud_frame.hpp"
#include "common/cloud/intensity_code.hpp"
#include "common/cloud/octree_code.hpp"
#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

using namespace cloud_form;  // NOLINT: the codec's own

Eigen::Vector3f to_point(const Cell& cell, double cell_m) {
  return {static_cast<float>(static_cast<double>(cell[0]) * cell_m),
          static_cast<float>(static_cast<double>(cell[1]) * cell_m),
          static_cast<float>(static_cast<double>(cell[2]) * cell_m)};
}

bool read_cell(VarintReader& in, Cell& cell) {
  for (auto& c : cell) {
    c = in.signed_varint();
    if (std::abs(static_cast<double>(c)) > farthest_cell) return false;
  }
  return in.ok();
}

Eigen::Vector3f to_point(std::uint64_t code, const Cell& low, double cell_m) {
  Cell cell = low;
  const auto offset = morton::cell(code);
  for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] += static_cast<std::int64_t>(offset[axis]);
  return to_point(cell, cell_m);
}

/// Reads what precedes a sweep's points; false if damaged. points_left: how many more the cloud may hold.
bool read_head(VarintReader& in, double cell_m, std::size_t& points_left, Sweep& sweep, Cell& low,
               std::size_t& points) {
  Cell origin{};
  if (!read_cell(in, origin)) return false;
  sweep.origin = to_point(origin, cell_m);
  points = in.varint();
  if (!in.ok() || points > points_left) return false;
  points_left -= points;
  return points == 0 || read_cell(in, low);
}

bool read_differences(VarintReader& in, double cell_m, KeyframeCloud& cloud) {
  std::size_t points_left = limits::cloud_points, points = 0;
  for (Sweep& sweep : cloud.sweeps) {
    Cell low{};
    if (!read_head(in, cell_m, points_left, sweep, low, points) || points > in.left()) return false;
    sweep.points.reserve(points);
    std::uint64_t code = 0;
    for (std::size_t i = 0; i < points; ++i) {
      const std::uint64_t step = in.varint();
      if (!in.ok() || step >> 3 * morton::axis_bits != 0) return false;
      code += step;
      if (code >> 3 * morton::axis_bits != 0) return false;
      sweep.points.push_back(to_point(code, low, cell_m));
    }
  }
  return in.left() == 0;
}

bool read_octree(VarintReader& in, double cell_m, KeyframeCloud& cloud) {
  struct Head {
    Cell low{};
    std::size_t points = 0;
    int levels = 0;
  };
  std::vector<Head> heads(cloud.sweeps.size());
  std::size_t points_left = octree_points;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    Head& head = heads[i];
    if (!read_head(in, cell_m, points_left, cloud.sweeps[i], head.low, head.points)) return false;
    if (head.points > 0) head.levels = static_cast<int>(std::min<std::uint64_t>(in.varint(), 255));
    if (!in.ok() || head.levels > morton::axis_bits) return false;
  }
  if (!is_quick(octree_points - points_left, in.left())) return false;
  OctreeDecoder decoder(in.rest());
  std::vector<std::uint64_t> codes;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    if (heads[i].points == 0) continue;
    if (!decoder.get(heads[i].points, heads[i].levels, codes)) return false;
    auto& points = cloud.sweeps[i].points;
    points.reserve(codes.size());
    for (const auto code : codes) points.push_back(to_point(code, heads[i].low, cell_m));
  }
  return decoder.done();
}

/// The parts of a content: the points as a content of their own, and the stream of intensities after them.
struct Parts {
  std::string_view points;
  std::optional<std::string_view> intensity;
};

Result<Parts> parts_of(std::string_view content) {
  VarintReader in(content);
  if (in.varint() != with_intensity) return Parts{content, std::nullopt};
  const std::uint64_t bytes = in.varint();
  if (!in.ok() || bytes > in.left()) return damaged("cut short before its intensities");
  return Parts{in.rest().substr(0, bytes), in.rest().substr(bytes)};
}

Result<KeyframeCloud> read_points(std::string_view content) {
  VarintReader in(content);
  const std::uint64_t form = in.varint();
  if (form == with_intensity) return damaged("intensities of a cloud that holds intensities");
  if (form != differences && form != octree)
    return damaged("form " + std::to_string(form) + ", only 1 to 3 are known: update whoever reads it");
  const float cell_m = in.float32();
  const std::uint64_t sweeps = in.varint();
  if (!in.ok() || !(cell_m >= 1e-4F && cell_m <= 10) || sweeps > limits::cloud_sweeps) return damaged("bad header");
  KeyframeCloud cloud;
  cloud.sweeps.resize(sweeps);
  const bool read = form == octree ? read_octree(in, cell_m, cloud) : read_differences(in, cell_m, cloud);
  if (!read) return damaged("its points do not fit its bytes");
  return cloud;
}

bool read_intensity(std::string_view stream, KeyframeCloud& cloud) {
  if (point_count(cloud) > intensity_points) return false;
  IntensityDecoder decoder(stream);
  for (Sweep& sweep : cloud.sweeps)
    if (!sweep.points.empty() && !decoder.get(sweep.points.size(), sweep.intensity)) return false;
  return decoder.done();
}

Result<KeyframeCloud> decode(std::string_view bytes, bool intensity) {
  const auto content = decompress(bytes);
  if (!content) return tl::unexpected(content.error());
  const auto parts = parts_of(*content);
  if (!parts) return tl::unexpected(parts.error());
  auto cloud = read_points(parts->points);
  if (cloud && intensity && parts->intensity && !read_intensity(*parts->intensity, *cloud))
    return damaged("its intensities do not fit its bytes");
  return cloud;
}

}  // namespace

Result<KeyframeCloud> decode_cloud(std::string_view bytes) { return decode(bytes, true); }

Result<KeyframeCloud> decode_points(std::string_view bytes) { return decode(bytes, false); }

Result<std::string> without_intensity(std::string_view bytes) {
  const auto content = decompress(bytes);
  if (!content) return tl::unexpected(content.error());
  const auto parts = parts_of(*content);
  if (!parts) return tl::unexpected(parts.error());
  if (!parts->intensity) return std::string(bytes);
  return compress(std::string(parts->points));
}

}  // namespace headframe
