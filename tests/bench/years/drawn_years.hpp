#pragma once
// Sessions for ./run bench years: each in a mine of its own, drawn by its number.

#include "tests/support/box_mine.hpp"

namespace headframe::bench {

/// A tunnel with branches, alcoves and rooms of changing width and height; no two numbers give the same. `keyframes`
/// keyframes, 3 m apart, with clouds.
test::Drive drawn_drive(std::uint64_t number, std::size_t keyframes);

/// Another robot in the same mine: it drives the last third of that path the other way and then into a branch that the
/// first has only looked into.
test::Drive drawn_visit(std::uint64_t number, std::size_t keyframes);

}  // namespace headframe::bench
