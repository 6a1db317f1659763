#include "common/dataset/columns.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>

namespace headframe::dataset {
namespace {

static_assert(std::endian::native == std::endian::little, "binary scans are read as they lie in memory");

template <class T>
double value_as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double value_of(const char* bytes, const Column& column) {
  if (column.kind == ScalarKind::real) return column.size_bytes == 4 ? value_as<float>(bytes) : value_as<double>(bytes);
  const bool is_signed = column.kind == ScalarKind::integer;
  switch (column.size_bytes) {
    case 1: return is_signed ? value_as<std::int8_t>(bytes) : value_as<std::uint8_t>(bytes);
    case 2: return is_signed ? value_as<std::int16_t>(bytes) : value_as<std::uint16_t>(bytes);
    case 4: return is_signed ? value_as<std::int32_t>(bytes) : value_as<std::uint32_t>(bytes);
    default: return is_signed ? value_as<std::int64_t>(bytes) : value_as<std::uint64_t>(bytes);
  }
}

}  // namespace

bool readable(ScalarKind kind, std::size_t size_bytes) {
  const bool wide = size_bytes == 4 || size_bytes == 8;
  return wide || (kind != ScalarKind::real && (size_bytes == 1 || size_bytes == 2));
}

std::optional<std::size_t> find_intensity(const std::vector<std::string_view>& names) {
  constexpr std::string_view prefix = "scalar_";
  for (const std::string_view wanted : {"intensity", "reflectivity", "reflectance"})
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::string name(names[i]);
      std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
      if (name == wanted || (name.starts_with(prefix) && name.substr(prefix.size()) == wanted)) return i;
    }
  return std::nullopt;
}

ScanTable points_of_binary(std::string_view bytes, std::size_t count, const PointColumns& columns) {
  const auto value = [&](const Column& column, std::size_t i) {
    return static_cast<float>(value_of(bytes.data() + column.offset_bytes + i * column.stride_bytes, column));
  };
  ScanTable table{Points(count)};
  for (std::size_t i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) table.points[i][axis] = value(columns.xyz[axis], i);
  if (!columns.intensity) return table;
  table.intensity.reserve(count);
  for (std::size_t i = 0; i < count; ++i) table.intensity.push_back(value(*columns.intensity, i));
  return table;
}

Result<ScanTable> points_of_text(Lines& lines, std::size_t count, std::size_t width, const PointWords& places) {
  const auto at = [&] { return "line " + std::to_string(lines.number()) + ": "; };
  ScanTable table;
  while (table.points.size() < count) {
    const auto line = lines.next();
    if (!line)
      return failure(ErrorCode::bad_input, at() + "truncated: the header says " + std::to_string(count) + " points, " +
                                               std::to_string(table.points.size()) + " are there");
    const auto parts = words(*line);
    if (parts.empty()) continue;
    if (parts.size() != width)
      return failure(ErrorCode::bad_input,
                     at() + std::to_string(parts.size()) + " values, the header says " + std::to_string(width));
    std::array<float, 4> row{};  // x, y, z, intensity
    for (std::size_t i = 0; i < (places.intensity ? 4 : 3); ++i) {
      const std::string_view word = parts[i < 3 ? places.xyz[i] : *places.intensity];
      const auto value = to_number(word);
      if (!value) return failure(ErrorCode::bad_input, at() + in_quotes(word) + " is no number");
      row[i] = static_cast<float>(*value);
    }
    table.points.emplace_back(row[0], row[1], row[2]);
    if (places.intensity) table.intensity.push_back(row[3]);
  }
  return table;
}

}  // namespace headframe::dataset
