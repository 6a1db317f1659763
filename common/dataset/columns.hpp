#pragma once
// Where x, y, z and the intensity lie in a table of points: what PCD and PLY have in common.

#include <array>
#include <optional>
#include <string_view>

#include "common/cloud/point_cloud.hpp"
#include "common/dataset/scan_formats.hpp"
#include "common/dataset/text.hpp"

namespace headframe::dataset {

enum class ScalarKind { real, integer, natural };  // IEEE 754; two's complement; unsigned

/// One value a point. Bytes are little endian.
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

/// The places of words in a line.
struct PointWords {
  std::array<std::size_t, 3> xyz{};
  std::optional<std::size_t> intensity = std::nullopt;
};

/// Which of a table's columns says how strong the returns were, by their names: intensity, reflectivity or reflectance,
/// whatever the case of their letters, also behind the "scalar_" of some programs. The first of these that is there.
std::optional<std::size_t> find_intensity(const std::vector<std::string_view>& names);

/// Whether a value of this kind and size can be read: real of 4 or 8 bytes, integers of 1, 2, 4 or 8.
bool readable(ScalarKind kind, std::size_t size_bytes);

/// The points of a binary table. All columns must be readable and lie within bytes for this count: the caller checks
/// it.
ScanTable points_of_binary(std::string_view bytes, std::size_t count, const PointColumns& columns);

/// The points of a text table, one a line of `width` words. Blank lines are passed over. Fails with the line when one
/// is longer or shorter, or has no number at one of the places, or when there are fewer than count.
Result<ScanTable> points_of_text(Lines& lines, std::size_t count, std::size_t width, const PointWords& places);

}  // namespace headframe::dataset
