#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "server/picture/sheet.hpp"

namespace headframe::picture {
namespace {

constexpr double pt_per_mm = 72 / 25.4;

/// Of Helvetica, in thousandths of its size, from blank to '~'.
constexpr std::array<std::uint16_t, 95> widths{
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333,  278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667,  611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278,  556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,  500, 334, 260, 334, 584};

/// In the encoding of the page's fonts, which is Latin 1 but for a few signs.
std::string latin(std::string_view utf8) {
  std::string out;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto c = static_cast<unsigned char>(utf8[i]);
    if (c < 0x80) {
      out += c < 0x20 || c == 0x7f ? '?' : static_cast<char>(c);
      continue;
    }
    const bool two = (c == 0xc2 || c == 0xc3) && i + 1 < utf8.size();
    if (two)
      out += static_cast<char>((c & 3U) << 6 | (static_cast<unsigned char>(utf8[i + 1]) & 0x3fU));
    else
      out += '?';
    while (i + 1 < utf8.size() && (static_cast<unsigned char>(utf8[i + 1]) & 0xc0U) == 0x80) ++i;
  }
  return out;
}

double width_mm(const std::string& text, double size_mm, bool bold) {
  double sum = 0;
  for (const char c : text) sum += c >= ' ' && c <= '~' ? widths.at(static_cast<std::size_t>(c - ' ')) : 556;
  return sum / 1000 * size_mm * (bold ? 1.06 : 1);
}

std::string colour(const Rgb& rgb, const char* command) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(3);
  for (const std::uint8_t channel : rgb) out << channel / 255.0 << ' ';
  out << command << '\n';
  return out.str();
}

/// What is drawn, in mm from the upper left: the first line turns the page's points to that.
std::string content(const Sheet& sheet) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(4) << pt_per_mm << " 0 0 " << -pt_per_mm << " 0 "
      << sheet.height_mm * pt_per_mm << " cm\n1 j\n";
  if (const SheetPicture& p = sheet.picture; p.columns > 0)
    out << "q " << p.width_mm << " 0 0 " << -p.height_mm << ' ' << p.x << ' ' << p.y + p.height_mm << " cm /I Do Q\n";
  for (const SheetPath& path : sheet.paths) {
    out << colour(path.colour, path.filled ? "rg" : "RG") << path.width_mm << " w\n";
    for (std::size_t i = 0; i < path.points.size(); ++i)
      out << path.points[i][0] << ' ' << path.points[i][1] << (i == 0 ? " m\n" : " l\n");
    out << (path.filled ? "f\n" : "S\n");
  }
  for (const SheetLine& line : sheet.lines)
    out << colour(line.colour, "RG") << line.width_mm << " w " << line.x0 << ' ' << line.y0 << " m " << line.x1 << ' '
        << line.y1 << " l S\n";
  for (const SheetText& text : sheet.texts) {
    const std::string words = latin(text.text);
    const double share = text.align == Align::left ? 0 : text.align == Align::middle ? 0.5 : 1;
    out << "BT " << colour(text.colour, "rg") << (text.bold ? "/B " : "/F ") << text.size_mm << " Tf 1 0 0 -1 "
        << text.x - share * width_mm(words, text.size_mm, text.bold) << ' ' << text.y << " Tm (";
    for (const char c : words) out << (c == '(' || c == ')' || c == '\\' ? "\\" : "") << c;
    out << ") Tj ET\n";
  }
  return out.str();
}

Result<std::string> deflated(const void* bytes, std::size_t size) {
  uLongf room = compressBound(size);
  std::string out(room, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &room, static_cast<const Bytef*>(bytes), size, 6) != Z_OK)
    return failure(ErrorCode::internal, "cannot pack the plan");
  out.resize(room);
  return out;
}

/// Objects by their numbers, from 1 on, and where each begins.
class Document {
 public:
  void add(const std::string& body) {
    at_.push_back(out_.size());
    out_ += std::to_string(at_.size()) + " 0 obj\n" + body + "\nendobj\n";
  }
  void add_stream(const std::string& entries, const std::string& bytes) {
    add("<<" + entries + "/Filter/FlateDecode/Length " + std::to_string(bytes.size()) + ">>stream\n" + bytes +
        "\nendstream");
  }
  std::string finished(int root, int info) {
    std::ostringstream tail;
    const std::size_t start = out_.size();
    tail << "xref\n0 " << at_.size() + 1 << "\n0000000000 65535 f \n";
    for (const std::size_t at : at_) tail << std::setw(10) << std::setfill('0') << at << " 00000 n \n";
    tail << "trailer\n<</Size " << at_.size() + 1 << "/Root " << root << " 0 R/Info " << info << " 0 R>>\nstartxref\n"
         << start << "\n%%EOF\n";
    return out_ + tail.str();
  }

 private:
  std::string out_ = "%PDF-1.5\n%\xe2\xe3\xcf\xd3\n";
  std::vector<std::size_t> at_;
};

std::string literal(std::string_view text) {
  std::string out = "(";
  for (const char c : latin(text)) {
    if (c == '(' || c == ')' || c == '\\') out += '\\';
    out += c;
  }
  return out + ")";
}

}  // namespace

Result<std::string> sheet_pdf(const Sheet& sheet) {
  const SheetPicture& picture = sheet.picture;
  const std::string drawn = content(sheet);
  const auto packed = deflated(drawn.data(), drawn.size());
  const auto pixels = deflated(picture.rgb.data(), picture.rgb.size());
  if (!packed || !pixels) return tl::unexpected(packed ? pixels.error() : packed.error());
  std::ostringstream page;
  page << "<</Type/Page/Parent 2 0 R/MediaBox[0 0 " << sheet.width_mm * pt_per_mm << ' ' << sheet.height_mm * pt_per_mm
       << "]/Contents 4 0 R/Resources<</Font<</F 5 0 R/B 6 0 R>>" << (picture.columns > 0 ? "/XObject<</I 8 0 R>>" : "")
       << ">>>>";
  const auto font = [](const char* name) {
    return std::string("<</Type/Font/Subtype/Type1/BaseFont/") + name + "/Encoding/WinAnsiEncoding>>";
  };
  Document document;
  document.add("<</Type/Catalog/Pages 2 0 R>>");
  document.add("<</Type/Pages/Kids[3 0 R]/Count 1>>");
  document.add(page.str());
  document.add_stream("", *packed);
  document.add(font("Helvetica"));
  document.add(font("Helvetica-Bold"));
  document.add("<</Title" + literal(sheet.title) + "/Producer(headframe)>>");
  if (picture.columns > 0)
    document.add_stream("/Type/XObject/Subtype/Image/Width " + std::to_string(picture.columns) + "/Height " +
                            std::to_string(picture.rows) + "/ColorSpace/DeviceRGB/BitsPerComponent 8",
                        *pixels);
  return document.finished(1, 7);
}

}  // namespace headframe::picture
