#include "server/cli/table.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

namespace headframe {
namespace {

bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }

std::size_t cells(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

std::string cut(const std::string& text, std::size_t width) {
  if (cells(text) <= width) return text;
  std::size_t end = 0;
  for (std::size_t seen = 0; end < text.size(); ++end)
    if (begins_character(text[end]) && ++seen == width) break;
  return text.substr(0, end) + "…";
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string shown = cut(text, width);
  const std::string spaces(width - cells(shown), ' ');
  return right ? spaces + shown : shown + spaces;
}

constexpr std::size_t gap = 2;
constexpr std::size_t narrowest = 4;

std::vector<std::size_t> widths_of(const Table& table, std::size_t most) {
  std::vector<std::size_t> widths;
  std::size_t total = 0;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::size_t width = cells(table.columns[c].title);
    for (const auto& row : table.rows) width = std::max(width, cells(row[c]));
    widths.push_back(width);
    total += width + (c > 0 ? gap : 0);
  }
  for (; most > 0 && total > most; --total) {
    const auto widest = std::max_element(widths.begin(), widths.end());
    if (widest == widths.end() || *widest <= narrowest) break;
    --*widest;
  }
  return widths;
}

/// Cells of a line where no column takes more than it needs to be read.
std::size_t readable_width(const Table& table) {
  constexpr std::size_t enough = 24;
  std::size_t total = 0;
  for (const std::size_t width : widths_of(table, 0)) total += std::min(width, enough) + gap;
  return total - std::min(total, gap);
}

void drop_column(Table& table, std::size_t column) {
  const auto at = static_cast<std::ptrdiff_t>(column);
  table.columns.erase(table.columns.begin() + at);
  for (auto& row : table.rows) row.erase(row.begin() + at);
}

}  // namespace

std::string Table::text(std::size_t width) const {
  if (width > 0 && readable_width(*this) > width) {
    const auto spared = std::max_element(columns.begin(), columns.end(),
                                         [](const Column& a, const Column& b) { return a.spare < b.spare; });
    if (spared != columns.end() && spared->spare > 0) {
      Table narrower = *this;
      drop_column(narrower, static_cast<std::size_t>(spared - columns.begin()));
      return narrower.text(width);
    }
  }
  const std::vector<std::size_t> widths = widths_of(*this, width);
  std::string out;
  const auto line = [&](const auto& cell_of) {
    std::string one;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (c > 0) one.append(gap, ' ');
      one += padded(cell_of(c), widths[c], columns[c].right);
    }
    out += one.substr(0, one.find_last_not_of(' ') + 1) + "\n";
  };
  line([&](std::size_t c) { return columns[c].title; });
  for (const auto& row : rows) line([&](std::size_t c) { return row[c]; });
  return out;
}

std::size_t terminal_width() {
  winsize size{};
  if (!isatty(STDOUT_FILENO) || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0) return 0;
  return size.ws_col;
}

std::string fixed(double value, int decimals) {
  std::array<char, 400> text;
  const int size = std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return {text.data(), static_cast<std::size_t>(std::max(size, 0))};
}

std::string bytes_text(double bytes) {
  constexpr std::array<const char*, 4> units{"kB", "MB", "GB", "TB"};
  if (bytes < 1000) return fixed(bytes, 0) + " B";
  std::size_t unit = 0;
  for (bytes /= 1000; bytes >= 999.95 && unit + 1 < units.size(); bytes /= 1000) ++unit;
  return fixed(bytes, 1) + " " + units.at(unit);
}

}  // namespace headframe
