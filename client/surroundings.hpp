#pragma once
// What others know around the robot, as the base station reported it. All of it in, or relative to, the robot's local
// frame.

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/coverage/coverage_tile.hpp"
#include "common/session/keyframe.hpp"
#include "common/session/map_question.hpp"

namespace headframe {

/// What trajectories and coverage have in common.
struct SurroundingsTold {
  enum class State {
    none,        // nothing: the session is not merged with any other; `missing` says why
    told,        // complete, as of `revision`
    unsupported  // this base station does not know the question
  };
  State state = State::none;
  std::uint64_t revision = 0;  // of the atlas
  std::uint64_t component = 0;
  SessionKey anchor = {};  // its local frame is the component's frame
  Pose T_component_local = Pose::Identity();
  std::string missing = {};
};

/// The paths of the other sessions of the component.
struct Trajectories : SurroundingsTold {
  struct Path {
    SessionKey session;
    double last_stamp_s = 0;      // of its newest keyframe, by its robot's clock
    std::optional<double> age_s;  // age of that keyframe when this was reported; nullopt: that clock has no date
    std::vector<Eigen::Vector3d> p_local_m;  // about every 2 m, to 0.1 m; in the robot's local frame
  };
  std::vector<Path> paths = {};
};

/// What was seen of the component, as a map from above in cells of 1 m: free space, walls, where robots drove.
struct Coverage : SurroundingsTold {
  std::map<TileIndex, std::shared_ptr<const CoverageTile>> tiles = {};  // in the component's frame
  std::map<std::uint64_t, SessionKey> sessions = {};                    // by the numbers used in cells

  /// The cell above or below this point of the robot's local frame; what == 0: not seen by anybody.
  CoverageCell at(const Eigen::Vector3d& p_local_m) const {
    const Eigen::Vector3d p_m = T_component_local * p_local_m;
    const auto x = static_cast<std::int64_t>(std::floor(p_m.x() / coverage_cell_m));
    const auto y = static_cast<std::int64_t>(std::floor(p_m.y() / coverage_cell_m));
    const auto tile_of = [](std::int64_t cell) {
      return static_cast<std::int32_t>(std::floor(static_cast<double>(cell) / coverage_tile_cells));
    };
    const TileIndex index{tile_of(x), tile_of(y)};
    const auto tile = tiles.find(index);
    if (tile == tiles.end()) return {};
    const auto column = x - std::int64_t{index.x} * coverage_tile_cells;
    const auto row = y - std::int64_t{index.y} * coverage_tile_cells;
    return tile->second->cells.at(static_cast<std::size_t>(row * coverage_tile_cells + column));
  }
};

/// Asks for the points that all sessions of the component have in a region.
struct MapQuestion {
  Region region;              // in the robot's local frame
  double resolution_m = 0.2;  // edge of the cubes in which points are merged: 0.05 to 5
  HeldVersion since = {};     // MapAround::held of an earlier answer: only what is new since; empty: all
};

struct MapAround {
  std::string refused = {};  // if not empty: why there is no map, and what to do
  std::uint64_t revision = 0;
  Eigen::Vector3d origin_local_m = Eigen::Vector3d::Zero();
  Points points = {};               // p_local = origin_local_m + point; one for each cube with a point
  std::size_t clouds = 0;           // number of clouds used
  std::size_t clouds_left_out = 0;  // older clouds of the region that exceeded the limit
  bool since =
      false;  // only what came since the question's `since`; false: all, and what was told before does not count
  HeldVersion held = {};
};

}  // namespace headframe
