#pragma once

#include <span>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/place/wall_search.hpp"

namespace headframe {

/// A stretch of a session's path, by keyframe index: [begin, end).
struct Piece {
  std::size_t begin = 0;
  std::size_t end = 0;
  auto operator<=>(const Piece&) const = default;
};

/// Cuts the path into pieces of length piece_m that overlap by half: short enough that drift does not bend them, long
/// enough to be distinguishable.
std::vector<Piece> cut_pieces(std::span<const Keyframe> keyframes, double piece_m);

/// Cuts the path into stretches that never pass above or below themselves, so that a ramp, or the levels of a mine,
/// become several maps instead of one in which all levels overlap. Also cuts where a map would grow beyond 500 m.
std::vector<Piece> cut_levels(std::span<const Keyframe> keyframes);

/// The wall maps of a session for the search: whole levels, which are searched, and pieces of 120 m, which are placed
/// on other sessions' levels. Immutable.
struct SessionWalls {
  struct Part {
    Piece piece;
    WallMap map;
  };
  struct Level {
    Piece piece;
    WallMap map;
    WallField field;
    std::vector<Part> parts;
  };
  std::vector<Level> levels;
  double path_m = 0;

  explicit SessionWalls(std::span<const Keyframe> keyframes);
  std::size_t bytes() const;
};

double path_m(std::span<const Keyframe> keyframes);

}  // namespace headframe
