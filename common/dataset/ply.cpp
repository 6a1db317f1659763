#include "common/dataset/columns.hpp"
#include "common/dataset/scan_formats.hpp"

namespace headframe::dataset {
namespace {

struct Property {
  std::string name;
  ScalarKind kind = ScalarKind::real;
  std::size_t size_bytes = 0;
  std::size_t offset_bytes = 0;
};

struct PlyHeader {
  std::string format;
  std::size_t count = 0;
  std::size_t row_bytes = 0;
  std::vector<Property> properties;  // of a vertex
  int elements = 0;
};

std::optional<Property> property_of(std::string_view type, std::string_view name) {
  const struct {
    std::string_view name, alias;
    ScalarKind kind;
    std::size_t size_bytes;
  } types[] = {{"char", "int8", ScalarKind::integer, 1},   {"uchar", "uint8", ScalarKind::natural, 1},
               {"short", "int16", ScalarKind::integer, 2}, {"ushort", "uint16", ScalarKind::natural, 2},
               {"int", "int32", ScalarKind::integer, 4},   {"uint", "uint32", ScalarKind::natural, 4},
               {"float", "float32", ScalarKind::real, 4},  {"double", "float64", ScalarKind::real, 8}};
  for (const auto& known : types)
    if (type == known.name || type == known.alias) return Property{std::string(name), known.kind, known.size_bytes, 0};
  return std::nullopt;
}

// Reads one line of the header. Returns false if it is invalid or not supported.
bool read_entry(PlyHeader& header, const std::vector<std::string_view>& parts) {
  const std::string_view key = parts[0];
  if (key == "comment" || key == "obj_info") return true;
  if (key == "format" && parts.size() == 3) {
    header.format = parts[1];
    return header.format == "ascii" || header.format == "binary_little_endian";
  }
  if (key == "element" && parts.size() == 3) {
    if (++header.elements > 1) return true;  // faces and the like come after the vertices and are not read
    const auto count = to_count(parts[2]);
    header.count = count.value_or(0);
    return count && parts[1] == "vertex";
  }
  if (key != "property" || header.elements == 0) return false;
  if (header.elements > 1) return true;
  auto property = parts.size() == 3 ? property_of(parts[1], parts[2]) : std::nullopt;
  if (!property) return false;
  property->offset_bytes = header.row_bytes;
  header.row_bytes += property->size_bytes;
  header.properties.push_back(*std::move(property));
  return true;
}

Result<PlyHeader> read_ply_header(Lines& lines) {
  PlyHeader header;
  if (lines.next() != "ply") return bad("line 1 is not 'ply'");
  while (true) {
    const auto line = lines.next();
    if (!line) return bad("the header has no end_header line (" + std::to_string(lines.number()) + " lines)");
    const auto parts = words(*line);
    if (parts.empty()) continue;
    if (parts[0] == "end_header") break;
    if (!read_entry(header, parts))
      return bad("line " + std::to_string(lines.number()) + ": " + in_quotes(*line) +
                 " cannot be read (known: ascii or binary_little_endian, vertices first and without lists)");
  }
  if (header.format.empty()) return bad("the header has no format line");
  if (header.elements == 0) return bad("the header has no 'element vertex' line");
  return header;
}

Result<std::array<std::size_t, 3>> find_axes(const PlyHeader& header) {
  std::array<std::size_t, 3> places{};
  for (int a = 0; a < 3; ++a) {
    const std::string name(1, "xyz"[a]);
    while (places[a] < header.properties.size() && header.properties[places[a]].name != name) ++places[a];
    if (places[a] == header.properties.size()) return bad("the vertices have no property '" + name + "'");
  }
  return places;
}

std::optional<std::size_t> place_of_intensity(const PlyHeader& header) {
  std::vector<std::string_view> names;
  for (const Property& property : header.properties) names.push_back(property.name);
  return find_intensity(names);
}

}  // namespace

Result<ScanTable> parse_ply(std::string_view bytes) {
  Lines lines(bytes);
  const auto header = read_ply_header(lines);
  if (!header) return tl::unexpected(header.error());
  const auto axes = find_axes(*header);
  if (!axes) return tl::unexpected(axes.error());
  const auto intensity = place_of_intensity(*header);
  if (header->format == "ascii")
    return points_of_text(lines, header->count, header->properties.size(), {*axes, intensity});

  const std::string_view body = bytes.substr(lines.at_byte());
  if (header->count > body.size() / header->row_bytes)
    return bad("truncated: the header says " + std::to_string(header->count) + " vertices of " +
               std::to_string(header->row_bytes) + " bytes, " + std::to_string(body.size()) + " bytes follow it");
  const auto column = [&](std::size_t place) {
    const Property& property = header->properties[place];
    return Column{property.kind, property.size_bytes, property.offset_bytes, header->row_bytes};
  };
  PointColumns columns{{column((*axes)[0]), column((*axes)[1]), column((*axes)[2])}};
  if (intensity) columns.intensity = column(*intensity);
  return points_of_binary(body, header->count, columns);
}

}  // namespace headframe::dataset
