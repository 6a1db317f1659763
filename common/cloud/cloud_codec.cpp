#include "common/cloud/cloud_codec.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>

#include "common/cloud/octree_code.hpp"
#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

enum Form : std::uint64_t { differences = 1, octree = 2 };
constexpr std::size_t octree_points = 262'144;   // of a cloud: its decoder takes some 0.2 us for each
constexpr std::size_t octree_points_a_byte = 2;  // at most
constexpr double farthest_cell = 1e12;           // keeps products of cells and metres exact in a double
constexpr std::size_t most_point_bytes = 9;      // 63 bits as a varint
constexpr std::size_t most_sweep_bytes = 7 * 10;
constexpr std::size_t most_content_bytes =
    limits::cloud_points * most_point_bytes + limits::cloud_sweeps * most_sweep_bytes + 16;

using Cell = std::array<std::int64_t, 3>;

bool to_cell(const Eigen::Vector3f& p, double cell_m, Cell& cell) {
  for (int i = 0; i < 3; ++i) {
    const double c = std::round(static_cast<double>(p[i]) / cell_m);
    if (!(std::abs(c) <= farthest_cell)) return false;
    cell[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(c);
  }
  return true;
}

Eigen::Vector3f to_point(const Cell& cell, double cell_m) {
  return {static_cast<float>(static_cast<double>(cell[0]) * cell_m),
          static_cast<float>(static_cast<double>(cell[1]) * cell_m),
          static_cast<float>(static_cast<double>(cell[2]) * cell_m)};
}

/// A sweep on the grid.
struct Cells {
  Cell origin{}, low{};              // low: the least on each axis
  std::vector<std::uint64_t> codes;  // Morton, of (cell - low), rising
};

/// nullptr, or what is wrong with the sweep.
const char* to_cells(const Sweep& sweep, double cell_m, Cells& out) {
  constexpr const char* not_finite = "has a coordinate that is not finite or too far away";
  if (!to_cell(sweep.origin, cell_m, out.origin)) return not_finite;
  if (sweep.points.empty()) return nullptr;
  std::vector<Cell> cells(sweep.points.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!to_cell(sweep.points[i], cell_m, cells[i])) return not_finite;
  out.low = cells.front();
  Cell high = out.low;
  for (const Cell& c : cells)
    for (std::size_t i = 0; i < 3; ++i) {
      out.low[i] = std::min(out.low[i], c[i]);
      high[i] = std::max(high[i], c[i]);
    }
  for (std::size_t i = 0; i < 3; ++i)
    if (high[i] - out.low[i] >= std::int64_t{1} << morton::axis_bits) return "is wider than 2^21 cells";
  out.codes.reserve(cells.size());
  for (const Cell& c : cells)
    out.codes.push_back(
        morton::code({static_cast<std::uint64_t>(c[0] - out.low[0]), static_cast<std::uint64_t>(c[1] - out.low[1]),
                      static_cast<std::uint64_t>(c[2] - out.low[2])}));
  std::sort(out.codes.begin(), out.codes.end());
  return nullptr;
}

/// How often the cube around the sweep has to be halved until it is a cell.
int levels_of(const Cells& cells) {
  std::uint64_t all = 0;
  for (const auto code : cells.codes) all |= code;
  return (static_cast<int>(std::bit_width(all)) + 2) / 3;
}

bool is_quick(std::size_t points, std::size_t stream_bytes) {
  return points <= octree_points && points / octree_points_a_byte <= stream_bytes;
}

std::string header(Form form, float cell_m, std::size_t sweeps) {
  std::string out;
  put_varint(out, form);
  put_float32(out, cell_m);
  put_varint(out, sweeps);
  return out;
}

void put_head(std::string& out, const Cells& sweep) {
  for (const auto c : sweep.origin) put_signed(out, c);
  put_varint(out, sweep.codes.size());
  if (sweep.codes.empty()) return;
  for (const auto c : sweep.low) put_signed(out, c);
}

std::string as_differences(const std::vector<Cells>& sweeps, float cell_m) {
  std::string out = header(differences, cell_m, sweeps.size());
  for (const Cells& sweep : sweeps) {
    put_head(out, sweep);
    std::uint64_t last = 0;
    for (const auto code : sweep.codes) put_varint(out, code - std::exchange(last, code));
  }
  return out;
}

/// Empty when it would be slow to read.
std::string as_octree(const std::vector<Cells>& sweeps, float cell_m) {
  std::string out = header(octree, cell_m, sweeps.size());
  OctreeEncoder encoder;
  std::size_t points = 0;
  for (const Cells& sweep : sweeps) {
    put_head(out, sweep);
    points += sweep.codes.size();
    if (sweep.codes.empty()) continue;
    const int levels = levels_of(sweep);
    out.push_back(static_cast<char>(levels));
    encoder.put(sweep.codes, levels);
  }
  const std::string stream = encoder.finish();
  return is_quick(points, stream.size()) ? out + stream : std::string();
}

Result<std::string> compress(const std::string& content) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, 1);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::string out(ZSTD_compressBound(content.size()), '\0');
  const std::size_t n = ZSTD_compress2(context.get(), out.data(), out.size(), content.data(), content.size());
  if (ZSTD_isError(n)) return failure(ErrorCode::internal, std::string("zstd: ") + ZSTD_getErrorName(n));
  out.resize(n);
  return out;
}

tl::unexpected<Error> damaged(const std::string& what) {
  return failure(ErrorCode::bad_input, "encoded cloud: " + what);
}

Result<std::string> decompress(std::string_view bytes) {
  if (bytes.size() > limits::cloud_bytes) return damaged("larger than the limit");
  const auto announced = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (announced == ZSTD_CONTENTSIZE_ERROR || announced == ZSTD_CONTENTSIZE_UNKNOWN)
    return damaged("not a zstd frame with its content size");
  if (announced > most_content_bytes) return damaged("content of " + std::to_string(announced) + " bytes announced");
  if (ZSTD_findFrameCompressedSize(bytes.data(), bytes.size()) != bytes.size())
    return damaged("cut short, or bytes after its end");
  std::string content(announced, '\0');
  const std::size_t n = ZSTD_decompress(content.data(), content.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(n)) return damaged(ZSTD_getErrorName(n));
  if (n != content.size()) return damaged("content shorter than announced");
  return content;
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

/// What stands before a sweep's points; false when it is damaged. points_left: how many the cloud may still hold.
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

}  // namespace

Result<std::string> encode_cloud(const KeyframeCloud& cloud, float cell_m) {
  const auto wrong = [](const std::string& what) { return failure(ErrorCode::invalid_argument, "cloud: " + what); };
  if (!(cell_m >= 1e-4F && cell_m <= 10)) return wrong("a cell must be between 0.1 mm and 10 m");
  if (cloud.sweeps.size() > limits::cloud_sweeps)
    return wrong(std::to_string(cloud.sweeps.size()) + " sweeps, at most " + std::to_string(limits::cloud_sweeps));
  if (point_count(cloud) > limits::cloud_points)
    return wrong(std::to_string(point_count(cloud)) + " points, at most " + std::to_string(limits::cloud_points));

  std::vector<Cells> sweeps(cloud.sweeps.size());
  for (std::size_t i = 0; i < sweeps.size(); ++i)
    if (const char* what = to_cells(cloud.sweeps[i], cell_m, sweeps[i]))
      return wrong("sweep " + std::to_string(i) + " " + what);
  std::string content = as_octree(sweeps, cell_m);
  if (content.empty()) content = as_differences(sweeps, cell_m);
  auto bytes = compress(content);
  if (bytes && bytes->size() > limits::cloud_bytes)
    return wrong(std::to_string(bytes->size()) + " bytes when encoded, at most " + std::to_string(limits::cloud_bytes));
  return bytes;
}

Result<KeyframeCloud> decode_cloud(std::string_view bytes) {
  const auto content = decompress(bytes);
  if (!content) return tl::unexpected(content.error());
  VarintReader in(*content);
  const std::uint64_t form = in.varint();
  if (form != differences && form != octree)
    return damaged("form " + std::to_string(form) + ", only 1 and 2 are known: update whoever reads it");
  const float cell_m = in.float32();
  const std::uint64_t sweeps = in.varint();
  if (!in.ok() || !(cell_m >= 1e-4F && cell_m <= 10) || sweeps > limits::cloud_sweeps) return damaged("bad header");
  KeyframeCloud cloud;
  cloud.sweeps.resize(sweeps);
  const bool read = form == octree ? read_octree(in, cell_m, cloud) : read_differences(in, cell_m, cloud);
  if (!read) return damaged("its points do not fit its bytes");
  return cloud;
}

}  // namespace headframe
