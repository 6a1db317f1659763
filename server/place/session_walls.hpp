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

/// Pieces of piece_m of path, each half over the one before: short enough that drift does not bend them, long enough to
/// be told apart.
std::vector<Piece> cut_pieces(std::span<const Keyframe> keyframes, double piece_m);

/// Stretches without a place that lies above or below another of the same stretch: a ramp, or levels of a mine, give
/// several maps instead of one with all levels on each other. Also cut where a map would grow beyond 500 m.
std::vector<Piece> cut_levels(std::span<const Keyframe> keyframes);

/// The walls of a session drawn for the search: its levels whole, as what is searched in, and in pieces of 120 m, which
/// are laid on others. Immutable.
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
