#pragma once
// A small bitmap font: five pixels wide, nine high with descenders.

#include <string_view>

namespace headframe::picture {

constexpr int glyph_width = 5;
constexpr int glyph_height = 9;
constexpr int glyph_pitch = 6;  // from one character to the next

/// Whether the character has ink there; (0, 0) is its upper left. Unprintable characters look like '?'.
bool glyph_pixel(char character, int column, int row);

}  // namespace headframe::picture
