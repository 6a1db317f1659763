#include "common/cloud/cloud_codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>

#include "common/cloud/cloud_form.hpp"
#include "common/cloud/cloud_frame.hpp"
#include "common/cloud/intensity_code.hpp"
#include "common/cloud/octree_code.hpp"
#include "common/cloud/varint.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

using namespace cloud_form;  // NOLINT: the codec's own

bool to_cell(const Eigen::Vector3f& p, double cell_m, Cell& cell) {
  for (int i = 0; i < 3; ++i) {
    const double c = std::round(static_cast<double>(p[i]) / cell_m);
    if (!(std::abs(c) <= farthest_cell)) return false;
    cell[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(c);
  }
  return true;
}

/// A sweep on the grid.
struct Cells {
  Cell origin{}, low{};              // low: the minimum on each axis
  std::vector<std::uint64_t> codes;  // Morton, of (cell - low), rising
  std::vector<std::uint8_t> levels;  // of their intensities, rising within a cell; empty: none
};

/// Sorts by code, and points of one cell by level.
void sort_together(std::vector<std::uint64_t>& codes, std::vector<std::uint8_t>& levels) {
  std::vector<std::pair<std::uint64_t, std::uint8_t>> both(codes.size());
  for (std::size_t i = 0; i < both.size(); ++i) both[i] = {codes[i], levels[i]};
  std::sort(both.begin(), both.end());
  for (std::size_t i = 0; i < both.size(); ++i) std::tie(codes[i], levels[i]) = both[i];
}

/// What is wrong with the sweep; nullptr if nothing is.
const char* to_cells(const Sweep& sweep, double cell_m, Cells& out) {
  constexpr const char* not_finite = "has a coordinate that is not finite or too far away";
  if (!sweep.intensity.empty() && sweep.intensity.size() != sweep.points.size())
    return "has other numbers of points and intensities";
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
  for (const std::uint8_t intensity : sweep.intensity) out.levels.push_back(intensity_level(intensity));
  if (out.levels.empty())
    std::sort(out.codes.begin(), out.codes.end());
  else
    sort_together(out.codes, out.levels);
  return nullptr;
}

/// How often the cube around the sweep has to be halved to reach a single cell.
int levels_of(const Cells& cells) {
  std::uint64_t all = 0;
  for (const auto code : cells.codes) all |= code;
  return (static_cast<int>(std::bit_width(all)) + 2) / 3;
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

/// Empty if it would be slow to decode.
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

/// The content without intensities, followed by them; without them if there are none, or too many.
std::string and_intensity(std::string content, const std::vector<Cells>& sweeps) {
  const auto has = [](const Cells& sweep) { return !sweep.levels.empty(); };
  std::size_t points = 0;
  for (const Cells& sweep : sweeps) points += sweep.codes.size();
  if (points > intensity_points || std::none_of(sweeps.begin(), sweeps.end(), has)) return content;
  std::string out;
  put_varint(out, with_intensity);
  put_varint(out, content.size());
  out += content;
  IntensityEncoder encoder;
  for (const Cells& sweep : sweeps)
    if (!sweep.codes.empty()) encoder.put(sweep.levels);
  return out + encoder.finish();
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
  auto bytes = compress(and_intensity(std::move(content), sweeps));
  if (bytes && bytes->size() > limits::cloud_bytes)
    return wrong(std::to_string(bytes->size()) + " bytes when encoded, at most " + std::to_string(limits::cloud_bytes));
  return bytes;
}

}  // namespace headframe
