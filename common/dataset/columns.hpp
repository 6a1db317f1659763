#pragma once
// Where x, y, z and the intensity are in a table of points; shared by PCD and PLY.

#include <array>
#include <optional>
#include <string_view>

#include "common/cloud/point_cloud.hpp"
#include "common/dataset/scan_formats.hpp"
#include "common/dataset/text.hpp"

namespace headframe::dataset {

enum class ScalarKind { real, integer, natural };  // IEEE 754; two's complement; unsigned

/// One value of every point. Bytes are little endian.
struct Column {
  ScalarKind kind = ScalarKind::real;
  std::size_t size_bytes = 0;
  std::size_t offset_bytes = 0;  // of the first point's value
  std::size_t stride_bytes = 0;  // from one point's value to the next
};

struct PointColumns {
  std::array<Column, 3> xyz;
  std::optional<Column> intensity = std::nullopt;
};

/// The word of a line that holds each value.
struct PointWords {
  std::array<std::size_t, 3> xyz{};
  std::optional<std::size_t> intensity = std::nullopt;
};

/// Finds the column with the intensity by its name: intensity, reflectivity or reflectance, in upper or lower case,
/// also with the prefix "scalar_" of some programs. Returns the first of these names that exists.
std::optional<std::size_t> find_intensity(const std::vector<std::string_view>& names);

/// Whether a value of this kind and size can be read: real of 4 or 8 bytes, integers of 1, 2, 4 or 8.
bool readable(ScalarKind kind, std::size_t size_bytes);

/// The points of a binary table. The caller has to check that all columns are readable and lie within bytes for this
/// count.
ScanTable points_of_binary(std::string_view bytes, std::size_t count, const PointColumns& columns);

/// The points of a text table, one line of `width` words for each. Blank lines are skipped. Fails, naming the line, if
/// a line is longer or shorter or lacks a number, or if there are fewer than count lines.
Result<ScanTable> points_of_text(Lines& lines, std::size_t count, std::size_t width, const PointWords& places);

}  // namespace headframe::dataset
