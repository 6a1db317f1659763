#include <cstdio>
#include <sstream>

#include "server/picture/canvas.hpp"
#include "server/picture/sheet.hpp"

namespace headframe::picture {
namespace {

std::string hex(const Rgb& colour) {
  std::array<char, 8> text;
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", colour[0], colour[1], colour[2]);
  return text.data();
}

/// Names are peers' bytes: nothing of them is markup, and control characters are no XML.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    }
  }
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const auto byte = [&](std::size_t i) -> std::uint32_t {
      return at + i < bytes.size() ? static_cast<unsigned char>(bytes[at + i]) : 0U;
    };
    const std::uint32_t three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (std::size_t i = 0; i < 4; ++i) out += at + i > bytes.size() ? '=' : digits[three >> (18 - 6 * i) & 63U];
  }
  return out;
}

Result<std::string> image(const SheetPicture& picture) {
  auto png = png_of(picture.columns, picture.rows, picture.rgb);
  if (!png) return tl::unexpected(png.error());
  std::ostringstream out;
  out << "<image x=\"" << picture.x << "\" y=\"" << picture.y << "\" width=\"" << picture.width_mm << "\" height=\""
      << picture.height_mm << "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," << base64(*png)
      << "\"/>\n";
  return out.str();
}

void write(std::ostream& out, const SheetPath& path) {
  const std::string colour = hex(path.colour);
  out << "<path d=\"";
  for (std::size_t i = 0; i < path.points.size(); ++i)
    out << (i == 0 ? 'M' : 'L') << path.points[i][0] << ' ' << path.points[i][1];
  if (path.filled)
    out << "Z\" fill=\"" << colour << "\"/>\n";
  else
    out << "\" fill=\"none\" stroke=\"" << colour << "\" stroke-width=\"" << path.width_mm
        << "\" stroke-linejoin=\"round\"/>\n";
}

void write(std::ostream& out, const SheetText& text) {
  const char* anchor = text.align == Align::left ? "start" : text.align == Align::middle ? "middle" : "end";
  out << "<text x=\"" << text.x << "\" y=\"" << text.y << "\" font-size=\"" << text.size_mm << "\" text-anchor=\""
      << anchor << "\" fill=\"" << hex(text.colour) << '"' << (text.bold ? " font-weight=\"bold\"" : "") << '>'
      << escaped(text.text) << "</text>\n";
}

}  // namespace

Result<std::string> sheet_svg(const Sheet& sheet) {
  std::ostringstream out;
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\""
      << sheet.width_mm << "mm\" height=\"" << sheet.height_mm << "mm\" viewBox=\"0 0 " << sheet.width_mm << ' '
      << sheet.height_mm << "\" font-family=\"Helvetica, Arial, sans-serif\">\n<title>" << escaped(sheet.title)
      << "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  if (sheet.picture.columns > 0) {
    const auto picture = image(sheet.picture);
    if (!picture) return tl::unexpected(picture.error());
    out << *picture;
  }
  for (const SheetPath& path : sheet.paths) write(out, path);
  for (const SheetLine& line : sheet.lines)
    out << "<line x1=\"" << line.x0 << "\" y1=\"" << line.y0 << "\" x2=\"" << line.x1 << "\" y2=\"" << line.y1
        << "\" stroke=\"" << hex(line.colour) << "\" stroke-width=\"" << line.width_mm << "\"/>\n";
  for (const SheetText& text : sheet.texts) write(out, text);
  out << "</svg>\n";
  return out.str();
}

}  // namespace headframe::picture
