#include "common/cloud/cloud_codec.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>

#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

constexpr std::uint64_t form = 1;
constexpr int axis_bits = 21;
constexpr double farthest_cell = 1e12;       // keeps products of cells and metres exact in a double
constexpr std::size_t most_point_bytes = 9;  // 63 bits as a varint
constexpr std::size_t most_sweep_bytes = 7 * 10;
constexpr std::size_t most_content_bytes =
    limits::cloud_points * most_point_bytes + limits::cloud_sweeps * most_sweep_bytes + 16;

using Cell = std::array<std::int64_t, 3>;

std::uint64_t spread(std::uint64_t v) {  // two zero bits after each of 21
  v = (v | v << 32) & 0x001f00000000ffffULL;
  v = (v | v << 16) & 0x001f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

std::uint64_t gather(std::uint64_t v) {
  v &= 0x1249249249249249ULL;
  v = (v | v >> 2) & 0x10c30c30c30c30c3ULL;
  v = (v | v >> 4) & 0x100f00f00f00f00fULL;
  v = (v | v >> 8) & 0x001f0000ff0000ffULL;
  v = (v | v >> 16) & 0x001f00000000ffffULL;
  return (v | v >> 32) & 0x1fffffULL;
}

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

/// nullptr, or what is wrong with the sweep.
const char* put_sweep(std::string& out, const Sweep& sweep, double cell_m) {
  constexpr const char* not_finite = "has a coordinate that is not finite or too far away";
  Cell origin{};
  if (!to_cell(sweep.origin, cell_m, origin)) return not_finite;
  for (const auto c : origin) put_signed(out, c);
  put_varint(out, sweep.points.size());
  if (sweep.points.empty()) return nullptr;

  std::vector<Cell> cells(sweep.points.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (!to_cell(sweep.points[i], cell_m, cells[i])) return not_finite;
  Cell low = cells.front(), high = low;
  for (const Cell& c : cells)
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], c[i]);
      high[i] = std::max(high[i], c[i]);
    }
  for (std::size_t i = 0; i < 3; ++i)
    if (high[i] - low[i] >= std::int64_t{1} << axis_bits) return "is wider than 2^21 cells";
  for (const auto c : low) put_signed(out, c);

  std::vector<std::uint64_t> codes;
  codes.reserve(cells.size());
  for (const Cell& c : cells) {
    std::uint64_t code = 0;
    for (std::size_t i = 0; i < 3; ++i) code |= spread(static_cast<std::uint64_t>(c[i] - low[i])) << i;
    codes.push_back(code);
  }
  std::sort(codes.begin(), codes.end());
  std::uint64_t last = 0;
  for (const auto code : codes) {
    put_varint(out, code - last);
    last = code;
  }
  return nullptr;
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

/// False when the sweep is damaged. points_left: how many the cloud may still hold.
bool read_sweep(VarintReader& in, double cell_m, std::size_t& points_left, Sweep& sweep) {
  Cell origin{}, low{};
  if (!read_cell(in, origin)) return false;
  sweep.origin = to_point(origin, cell_m);
  const std::uint64_t count = in.varint();
  if (!in.ok() || count > points_left || count > in.left()) return false;  // a point takes at least a byte
  points_left -= count;
  if (count == 0) return true;
  if (!read_cell(in, low)) return false;
  sweep.points.reserve(count);
  std::uint64_t code = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t step = in.varint();
    if (!in.ok() || step >> 3 * axis_bits != 0) return false;
    code += step;
    if (code >> 3 * axis_bits != 0) return false;
    Cell cell = low;
    for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] += static_cast<std::int64_t>(gather(code >> axis));
    sweep.points.push_back(to_point(cell, cell_m));
  }
  return true;
}

}  // namespace

Result<std::string> encode_cloud(const KeyframeCloud& cloud, float cell_m) {
  const auto wrong = [](const std::string& what) { return failure(ErrorCode::invalid_argument, "cloud: " + what); };
  if (!(cell_m >= 1e-4F && cell_m <= 10)) return wrong("a cell must be between 0.1 mm and 10 m");
  if (cloud.sweeps.size() > limits::cloud_sweeps)
    return wrong(std::to_string(cloud.sweeps.size()) + " sweeps, at most " + std::to_string(limits::cloud_sweeps));
  if (point_count(cloud) > limits::cloud_points)
    return wrong(std::to_string(point_count(cloud)) + " points, at most " + std::to_string(limits::cloud_points));

  std::string content;
  content.reserve(point_count(cloud) * 3);
  put_varint(content, form);
  put_float32(content, cell_m);
  put_varint(content, cloud.sweeps.size());
  for (std::size_t i = 0; i < cloud.sweeps.size(); ++i)
    if (const char* what = put_sweep(content, cloud.sweeps[i], cell_m))
      return wrong("sweep " + std::to_string(i) + " " + what);
  auto bytes = compress(content);
  if (bytes && bytes->size() > limits::cloud_bytes)
    return wrong(std::to_string(bytes->size()) + " bytes when encoded, at most " + std::to_string(limits::cloud_bytes));
  return bytes;
}

Result<KeyframeCloud> decode_cloud(std::string_view bytes) {
  const auto content = decompress(bytes);
  if (!content) return tl::unexpected(content.error());
  VarintReader in(*content);
  if (const auto f = in.varint(); f != form) return damaged("form " + std::to_string(f) + ", only 1 is known");
  const float cell_m = in.float32();
  const std::uint64_t sweeps = in.varint();
  if (!in.ok() || !(cell_m >= 1e-4F && cell_m <= 10) || sweeps > limits::cloud_sweeps) return damaged("bad header");
  KeyframeCloud cloud;
  cloud.sweeps.resize(sweeps);
  std::size_t points_left = limits::cloud_points;
  for (std::size_t i = 0; i < sweeps; ++i)
    if (!read_sweep(in, cell_m, points_left, cloud.sweeps[i])) return damaged("bad sweep " + std::to_string(i));
  if (in.left() != 0) return damaged("bytes after the last sweep");
  return cloud;
}

}  // namespace headframe
