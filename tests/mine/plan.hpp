#pragma once
// The plan of a mine: where its drifts run and what stands in them. Metres, world frame, z up.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/mine/random.hpp"

namespace headframe::mine {

/// A tunnel between two nodes. `line` runs along the floor's middle, from the place of node a to that of node b.
struct Drift {
  std::size_t a = 0;
  std::size_t b = 0;
  std::vector<Eigen::Vector3d> line;
  double width_m = 5;
  double height_m = 3.5;
};

/// An upright box: a niche when carved out of the rock, a vehicle or a cabinet when it stands in the drift.
struct Box {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();
  double yaw_rad = 0;
};

/// Gravel: a cone on the floor.
struct Pile {
  Eigen::Vector3d foot = Eigen::Vector3d::Zero();
  double radius_m = 1;
  double height_m = 1;
};

struct Pipe {
  std::vector<Eigen::Vector3d> line;
  double radius_m = 0.15;
};

/// One of several pieces that a tile may be a copy of, turned by so many quarter turns.
struct TilePiece {
  std::uint8_t number = 0, quarter_turns = 0;
};

/// The pieces' roughness is drawn from seeds from here on, which no shape of a tile has.
inline constexpr std::uint64_t piece_seed = 100;

/// Walls that repeat: the mine is laid out on square tiles, and every tile of one shape, or of one piece where pieces
/// are named, is rough in the same way.
struct Tiling {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // the centre of tile (0, 0)
  double tile_m = 20;
  std::size_t columns = 0;
  std::vector<std::uint8_t> open;  // per tile, row by row: bit k is set when it opens towards k * 90 deg; 0: no tile
  std::vector<TilePiece> pieces;   // per tile: which piece it is; empty: its shape tells
};

struct Plan {
  std::vector<Eigen::Vector3d> nodes;
  std::vector<Drift> drifts;
  std::vector<Box> niches;
  std::vector<Box> vehicles;
  std::vector<Pile> piles;
  std::vector<Pipe> pipes;
  std::optional<Tiling> tiling;
  double blend_m = 1.5;         // how far drifts flow into each other at a junction
  double roughness = 1;         // 0: walls as smooth as the formulas
  std::uint64_t rock_seed = 1;  // of the walls' roughness
};

enum class Kind { junctions, grid, room_and_pillar, ramp, straight, look_alike, varied, tiled_cave };

/// The kind of that name (as the enumerator is spelled), or nothing.
std::optional<Kind> kind_of(std::string_view name);
std::string_view to_string(Kind kind);
/// All names, comma separated, for messages and help.
std::string kind_list();

/// A mine of about 150 m by 150 m, connected, with dead ends and loops as its kind has them. The same seed gives the
/// same mine. Two seeds of `look_alike`, or of `tiled_cave`, are laid out differently from the same tiles.
Plan make_plan(Kind kind, std::uint64_t seed);

/// Puts pipes, vehicles, niches and gravel along the drifts. Their middle stays free for a robot.
void furnish(Plan& plan, Rng rng);

/// The plan somewhere else: all of it moved by offset_m.
Plan moved(Plan plan, const Eigen::Vector3d& offset_m);

}  // namespace headframe::mine
