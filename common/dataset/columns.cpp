#include "common/dataset/columns.hpp"

#include <algorithm>
#include <bit>
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

Points points_of_binary(std::string_view bytes, std::size_t count, const XyzColumns& columns) {
  Points points(count);
  for (std::size_t i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const Column& column = columns[axis];
      const char* at = bytes.data() + column.offset_bytes + i * column.stride_bytes;
      points[i][axis] = static_cast<float>(value_of(at, column));
    }
  return points;
}

Result<Points> points_of_text(Lines& lines, std::size_t count, std::size_t width,
                              const std::array<std::size_t, 3>& xyz) {
  const auto at = [&] { return "line " + std::to_string(lines.number()) + ": "; };
  Points points;
  while (points.size() < count) {
    const auto line = lines.next();
    if (!line)
      return failure(ErrorCode::bad_input, at() + "truncated: the header says " + std::to_string(count) + " points, " +
                                               std::to_string(points.size()) + " are there");
    const auto parts = words(*line);
    if (parts.empty()) continue;
    if (parts.size() != width)
      return failure(ErrorCode::bad_input,
                     at() + std::to_string(parts.size()) + " values, the header says " + std::to_string(width));
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = to_number(parts[xyz[axis]]);
      if (!value) return failure(ErrorCode::bad_input, at() + in_quotes(parts[xyz[axis]]) + " is no number");
      p[axis] = static_cast<float>(*value);
    }
    points.push_back(p);
  }
  return points;
}

}  // namespace headframe::dataset
