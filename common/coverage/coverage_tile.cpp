#include "common/coverage/coverage_tile.hpp"

#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/cloud/varint.hpp"

namespace headframe {
namespace {

constexpr int zstd_level = 19;  // tiles are small: some tenths of a millisecond
constexpr std::size_t cells_of_tile = coverage_tile_cells * coverage_tile_cells;
constexpr std::size_t most_tile_bytes = 64 * 1024;  // 1024 cells and 1024 sessions take 30 KiB at most

std::string content_of(const CoverageTile& tile) {
  std::string out;
  std::map<std::uint32_t, std::uint64_t> place;  // of a session in the list
  put_varint(out, tile.seen_by.size());
  std::int32_t newest = std::numeric_limits<std::int32_t>::min();
  for (const auto& [session, last] : tile.seen_by) newest = std::max(newest, last);
  put_signed(out, newest);
  for (const auto& [session, last] : tile.seen_by) {
    place.emplace(session, place.size());
    put_varint(out, session);
    put_varint(out, static_cast<std::uint64_t>(std::int64_t{newest} - last));
  }
  for (const CoverageCell& cell : tile.cells) out.push_back(static_cast<char>(cell.what));
  for (const CoverageCell& cell : tile.cells)
    if (cell.what != 0) put_varint(out, place.at(cell.session));
  for (const CoverageCell& cell : tile.cells)
    if (cell.what != 0) put_varint(out, static_cast<std::uint64_t>(std::int64_t{newest} - cell.last_seen));
  return out;
}

Result<std::string> unpacked(std::string_view bytes) {
  const auto size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > most_tile_bytes)
    return failure(ErrorCode::bad_input, "a tile of coverage is no zstd frame of a size that a tile may have");
  std::string content(size, '\0');
  const std::size_t written = ZSTD_decompress(content.data(), content.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(written) != 0 || written != content.size())
    return failure(ErrorCode::bad_input, "a tile of coverage does not unpack");
  return content;
}

/// Reads what follows the list of sessions: kinds, who, when. False: damaged.
bool read_cells(VarintReader& in, const std::vector<std::uint32_t>& sessions, std::int64_t newest, CoverageTile& tile) {
  for (CoverageCell& cell : tile.cells) {
    const std::uint64_t what = in.varint();  // a kind is less than 128: one byte
    if (what > (coverage_free | coverage_wall | coverage_path)) return false;
    cell.what = static_cast<std::uint8_t>(what);
  }
  for (CoverageCell& cell : tile.cells) {
    if (cell.what == 0) continue;
    const std::uint64_t place = in.varint();
    if (place >= sessions.size()) return false;
    cell.session = sessions[place];
  }
  for (CoverageCell& cell : tile.cells) {
    if (cell.what == 0) continue;
    const std::uint64_t before = in.varint();
    if (before > std::numeric_limits<std::uint32_t>::max()) return false;
    cell.last_seen = static_cast<std::int32_t>(newest - static_cast<std::int64_t>(before));
  }
  return in.ok() && in.left() == 0;
}

}  // namespace

std::string encode_tile(const CoverageTile& tile) {
  if (tile.seen_by.empty()) return "";
  const std::string content = content_of(tile);
  std::string out(ZSTD_compressBound(content.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), content.data(), content.size(), zstd_level));
  return out;
}

Result<CoverageTile> decode_tile(std::string_view bytes) {
  CoverageTile tile;
  if (bytes.empty()) return tile;
  const auto content = unpacked(bytes);
  if (!content) return tl::unexpected(content.error());
  const auto damaged = failure(ErrorCode::bad_input, "a tile of coverage is damaged");
  VarintReader in(*content);
  const std::uint64_t count = in.varint();
  const std::int64_t newest = in.signed_varint();
  constexpr auto least = std::numeric_limits<std::int32_t>::min(), most = std::numeric_limits<std::int32_t>::max();
  if (count == 0 || count > in.left() / 2 || newest < least || newest > most) return damaged;
  std::vector<std::uint32_t> sessions;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t session = in.varint(), before = in.varint();
    constexpr auto word = std::numeric_limits<std::uint32_t>::max();
    if (session > word || before > word) return damaged;
    sessions.push_back(static_cast<std::uint32_t>(session));
    tile.seen_by[sessions.back()] = static_cast<std::int32_t>(newest - static_cast<std::int64_t>(before));
  }
  if (!in.ok() || !read_cells(in, sessions, newest, tile)) return damaged;
  return tile;
}

std::int32_t coverage_time(double stamp_s) {
  constexpr double most = 2e9;
  const double step = std::floor(stamp_s / coverage_time_s);
  return static_cast<std::int32_t>(std::isfinite(step) ? std::clamp(step, -most, most) : 0);
}

}  // namespace headframe
