#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/printable.hpp"  // peers choose the names

namespace headframe {

/// Columns of text, the first ones left and those marked right-aligned. Where a line does not fit, columns that can be
/// spared go first, then the widest are cut with "…".
struct Table {
  struct Column {
    std::string title;
    bool right = false;
    int spare = 0;  // left out the sooner the greater; 0: never
  };
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;  // as many cells as columns

  /// Lines of at most width cells (as far as 4 cells a column allow); 0: as wide as needed.
  std::string text(std::size_t width) const;
};

/// Of the terminal on stdout; 0 when stdout is none.
std::size_t terminal_width();

/// A view that takes the width, as wide as the terminal.
template <class View>
auto across_terminal(View view) {
  return [view](const auto& json) { return view(json, terminal_width()); };
}

/// "981 B", "1.2 MB".
std::string bytes_text(double bytes);
std::string fixed(double value, int decimals);

}  // namespace headframe
