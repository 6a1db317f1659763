// Our own reader, because PCL's (1.13) fails on damaged files: of 1203 files with changed, missing or duplicated bytes,
// 179 crashed it with a segmentation fault, among them one with only its first word damaged ("VE9RSION .7").
#include <algorithm>
#include <cstring>

#include "common/dataset/columns.hpp"
#include "common/dataset/lzf.hpp"
#include "common/dataset/scan_formats.hpp"

namespace headframe::dataset {
namespace {

constexpr std::size_t most_points = 1U << 28;     // both keep products of counts and sizes far from overflow
constexpr std::size_t most_row_bytes = 1U << 16;  // of one point

struct Field {
  std::string name;
  ScalarKind kind = ScalarKind::real;
  std::size_t size_bytes = 4;
  std::size_t count = 1;
  std::size_t bytes() const { return size_bytes * count; }
};

struct PcdHeader {
  std::vector<Field> fields;
  std::optional<std::size_t> width, height, points;
  std::string data;

  std::size_t row_bytes() const {
    std::size_t sum = 0;
    for (const Field& field : fields) sum += field.bytes();
    return sum;
  }
  std::size_t row_words() const {
    std::size_t sum = 0;
    for (const Field& field : fields) sum += field.count;
    return sum;
  }
};

std::optional<std::size_t> count_up_to(std::string_view word, std::size_t most) {
  const auto n = to_count(word);
  if (!n || *n > most) return std::nullopt;
  return static_cast<std::size_t>(*n);
}

std::optional<ScalarKind> kind_of(std::string_view word) {
  if (word == "F") return ScalarKind::real;
  if (word == "I") return ScalarKind::integer;
  if (word == "U") return ScalarKind::natural;
  return std::nullopt;
}

// SIZE, TYPE and COUNT have one value for each field. Returns false if one is invalid.
bool set_field(Field& field, std::string_view key, std::string_view value) {
  if (key == "TYPE") {
    const auto kind = kind_of(value);
    field.kind = kind.value_or(field.kind);
    return kind.has_value();
  }
  const auto n = count_up_to(value, most_row_bytes);
  if (!n || (key == "SIZE" && *n == 0)) return false;
  (key == "SIZE" ? field.size_bytes : field.count) = *n;
  return true;
}

// Reads one line of the header. Returns false if it is invalid.
bool read_entry(PcdHeader& header, const std::vector<std::string_view>& parts) {
  const std::string_view key = parts[0];
  if (key == "VERSION" || key == "VIEWPOINT") return true;
  if (key == "FIELDS") {
    header.fields.clear();
    for (std::size_t i = 1; i < parts.size(); ++i) header.fields.push_back({std::string(parts[i])});
    return parts.size() > 1;
  }
  if (key == "SIZE" || key == "TYPE" || key == "COUNT") {
    if (parts.size() != header.fields.size() + 1) return false;
    for (std::size_t i = 0; i < header.fields.size(); ++i)
      if (!set_field(header.fields[i], key, parts[i + 1])) return false;
    return true;
  }
  if (parts.size() != 2) return false;
  if (key == "DATA") header.data = parts[1];
  if (key == "WIDTH") header.width = count_up_to(parts[1], most_points);
  if (key == "HEIGHT") header.height = count_up_to(parts[1], most_points);
  if (key == "POINTS") header.points = count_up_to(parts[1], most_points);
  return key == "DATA" || (key == "WIDTH" && header.width) || (key == "HEIGHT" && header.height) ||
         (key == "POINTS" && header.points);
}

Result<PcdHeader> read_pcd_header(Lines& lines) {
  PcdHeader header;
  while (header.data.empty()) {
    const auto line = lines.next();
    if (!line) return bad("the header has no DATA line (" + std::to_string(lines.number()) + " lines)");
    const auto parts = words(*line);
    if (parts.empty() || parts[0].starts_with('#')) continue;
    if (!read_entry(header, parts))
      return bad("line " + std::to_string(lines.number()) + ": " + in_quotes(*line) + " is no PCD header line");
  }
  if (header.fields.empty()) return bad("the header has no FIELDS line");
  if (header.row_bytes() > most_row_bytes)
    return bad("the header says " + std::to_string(header.row_bytes()) + " bytes a point, more than a point can have");
  return header;
}

Result<std::size_t> count_of(const PcdHeader& header) {
  if (!header.width && !header.points) return bad("the header has neither WIDTH nor POINTS");
  const std::size_t grid = header.width.value_or(0) * header.height.value_or(1);
  const std::size_t count = header.points.value_or(grid);
  if (header.width && grid != count)
    return bad("the header contradicts itself: WIDTH x HEIGHT is " + std::to_string(grid) + ", POINTS is " +
               std::to_string(count));
  if (count > most_points)
    return bad("the header says " + std::to_string(count) + " points, more than a scan can have");
  return count;
}

/// The position of a field.
struct Place {
  std::size_t field = 0;
  std::size_t bytes_before = 0;  // of one point, ahead of this field
  std::size_t words_before = 0;
};

struct Places {
  std::array<Place, 3> xyz;
  std::optional<Place> intensity;
};

Place place_of(const PcdHeader& header, std::size_t field) {
  Place place{field};
  for (std::size_t i = 0; i < field; ++i) {
    place.bytes_before += header.fields[i].bytes();
    place.words_before += header.fields[i].count;
  }
  return place;
}

bool is_one_number(const Field& field) { return field.count == 1 && readable(field.kind, field.size_bytes); }

Result<Places> find_places(const PcdHeader& header) {
  std::vector<std::string_view> names;
  for (const Field& field : header.fields) names.push_back(field.name);
  Places places;
  for (int a = 0; a < 3; ++a) {
    const std::string name(1, "xyz"[a]);
    const auto field = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    if (field == names.size()) return bad("no field '" + name + "'");
    if (!is_one_number(header.fields[field]))
      return bad("field '" + name + "' is not one number of 1, 2, 4 or 8 bytes");
    places.xyz[a] = place_of(header, field);
  }
  const auto intensity = find_intensity(names);
  if (intensity && is_one_number(header.fields[*intensity])) places.intensity = place_of(header, *intensity);
  return places;
}

/// column(place) returns the position of a field's values.
template <class ColumnOf>
PointColumns columns_of(const Places& places, const ColumnOf& column) {
  PointColumns columns{{column(places.xyz[0]), column(places.xyz[1]), column(places.xyz[2])}};
  if (places.intensity) columns.intensity = column(*places.intensity);
  return columns;
}

Result<ScanTable> read_binary(const PcdHeader& header, const Places& places, std::size_t count, std::string_view body) {
  const std::size_t row = header.row_bytes();
  if (count > body.size() / row)
    return bad("truncated: the header says " + std::to_string(count) + " points of " + std::to_string(row) +
               " bytes, " + std::to_string(body.size()) + " bytes follow it");
  const auto column = [&](const Place& place) {
    const Field& field = header.fields[place.field];
    return Column{field.kind, field.size_bytes, place.bytes_before, row};
  };
  return points_of_binary(body, count, columns_of(places, column));
}

// Two lengths, then LZF data with all values of the first field, then all of the second, and so on.
Result<ScanTable> read_compressed(const PcdHeader& header, const Places& places, std::size_t count,
                                  std::string_view body) {
  if (count == 0) return ScanTable{};
  std::uint32_t lengths[2] = {0, 0};
  if (body.size() < sizeof lengths) return bad("truncated: no room for the two lengths of compressed data");
  std::memcpy(lengths, body.data(), sizeof lengths);
  body.remove_prefix(sizeof lengths);
  if (lengths[0] > body.size())
    return bad("truncated: " + std::to_string(lengths[0]) + " bytes of compressed data announced, " +
               std::to_string(body.size()) + " there");
  if (lengths[1] != count * header.row_bytes() || lengths[1] / lzf_most_growth > lengths[0] ||
      lengths[1] > most_scan_bytes)
    return bad("the header says " + std::to_string(count) + " points of " + std::to_string(header.row_bytes()) +
               " bytes, the compressed data unpacks to " + std::to_string(lengths[1]) + " bytes");
  const auto unpacked = lzf_unpack(body.substr(0, lengths[0]), lengths[1]);
  if (!unpacked) return bad("the compressed data is damaged");
  const auto column = [&](const Place& place) {
    const Field& field = header.fields[place.field];
    return Column{field.kind, field.size_bytes, place.bytes_before * count, field.size_bytes};
  };
  return points_of_binary(*unpacked, count, columns_of(places, column));
}

}  // namespace

Result<ScanTable> parse_pcd(std::string_view bytes) {
  Lines lines(bytes);
  const auto header = read_pcd_header(lines);
  if (!header) return tl::unexpected(header.error());
  const auto count = count_of(*header);
  if (!count) return tl::unexpected(count.error());
  const auto places = find_places(*header);
  if (!places) return tl::unexpected(places.error());
  const std::string_view body = bytes.substr(lines.at_byte());
  if (header->data == "binary") return read_binary(*header, *places, *count, body);
  if (header->data == "binary_compressed") return read_compressed(*header, *places, *count, body);
  if (header->data != "ascii")
    return bad("DATA " + in_quotes(header->data) + " is not ascii, binary or binary_compressed");
  const auto& [x, y, z] = places->xyz;
  PointWords words_of_point{{x.words_before, y.words_before, z.words_before}};
  if (places->intensity) words_of_point.intensity = places->intensity->words_before;
  return points_of_text(lines, *count, header->row_words(), words_of_point);
}

}  // namespace headframe::dataset
