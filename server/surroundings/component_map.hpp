#pragma once
// Paths and coverage of one component, versioned so that a robot with an earlier version gets only what is newer.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/coverage/coverage_tile.hpp"
#include "common/result.hpp"
#include "server/atlas/atlas.hpp"
#include "server/surroundings/coverage_grid.hpp"

namespace headframe {

/// Source of keyframes, like Store::each_keyframe.
using ReadKeyframes = std::function<Result<void>(SessionId, std::uint64_t, const std::function<void(Keyframe)>&)>;

/// Path points as they are sent: in the component's frame, in units of path_unit_m.
inline constexpr double path_unit_m = 0.1;
using PathPoint = std::array<std::int32_t, 3>;

/// Everything that was ever reported has a version; versions only increase. A page contains everything newer than one
/// version up to another. Not thread safe.
class ComponentMap {
 public:
  explicit ComponentMap(std::size_t most_tiles) : most_tiles_(most_tiles), grid_(most_tiles) {}

  /// Reads new keyframes, of sessions for which `durable` says that there are more. If a session moved by more than
  /// moved_m, or left, everything is redrawn. `stop` is called between keyframes; when it returns true, the rest is
  /// left out. Returns the first failure to read, but draws everything else.
  Result<void> refresh(const Component& component, const std::map<SessionId, std::uint64_t>& durable,
                       const ReadKeyframes& read, const std::function<bool()>& stop);

  /// Tells how often the session's keyframes were moved; if that is new, the next refresh() reads them again.
  void moved(SessionId session, std::uint64_t moves);

  struct PathPiece {
    SessionId session = 0;
    std::size_t first = 0;          // number of points of the path before these
    std::optional<PathPoint> last;  // the last of those
    std::vector<PathPoint> points;
    bool gone = false;
  };
  struct Piece {  // everything newer than a version, up to this one
    std::uint64_t version = 0;
    bool more = false;
    std::vector<SessionId> placed = {};  // sessions whose placement is new
    std::vector<PathPiece> paths = {};
    std::vector<std::pair<TileIndex, std::string>> tiles = {};  // encoded
  };
  /// What `receiver` has to be told about the other sessions' paths since `version`, about page_bytes of it. Nullopt:
  /// nothing.
  std::optional<Piece> paths_after(std::uint64_t version, SessionId receiver, std::size_t page_bytes) const;
  /// The same for the coverage, which includes all sessions.
  std::optional<Piece> coverage_after(std::uint64_t version, std::size_t page_bytes) const;

  struct PlacedKeyframe {
    std::uint64_t sequence = 0;
    double stamp_s = 0;
    Pose T_local_sensor = Pose::Identity();
  };
  /// The keyframes read of a session; null if it is not in the component.
  const std::vector<PlacedKeyframe>* keyframes(SessionId session) const;
  double last_stamp_s(SessionId session) const;

  /// Assigns versions to clouds. `sequences` are all present ones; those not seen before, or of a session that moved,
  /// get a new version.
  void note_clouds(SessionId session, const std::vector<std::uint64_t>& sequences);
  std::uint64_t cloud_version(SessionId session, std::uint64_t sequence) const;

  /// The version in which something already drawn last moved or left; 0: none did.
  std::uint64_t redrawn() const { return redrawn_; }
  /// The newest version.
  std::uint64_t version() const { return version_; }
  /// Whether something was left out because the limit of tiles was reached.
  bool full() const { return grid_.full(); }
  std::size_t tiles() const { return grid_.tiles().size(); }

  static constexpr double moved_m = 0.25;       // at any keyframe of the path; smaller changes are not reported
  static constexpr double point_every_m = 2;    // of a path
  static constexpr double longest_step_m = 15;  // between keyframes; beyond, the robot did not drive straight

 private:
  struct Point {
    PathPoint at{};
    std::uint64_t version = 0;
  };
  struct Path {
    Pose T_component_session = Pose::Identity();  // as drawn
    std::vector<PlacedKeyframe> keyframes;
    std::vector<Point> points;
    std::map<std::uint64_t, std::uint64_t> clouds;  // with their versions
    std::uint64_t placed = 0, left = 0;             // the versions in which it was placed and in which it left
    bool gone = false;
    std::uint64_t moves = 0;  // number of moves of its keyframes when they were read
    bool stale = false;       // they were moved since
  };
  struct Item {
    enum class Kind { placed, point, gone, tile };
    std::uint64_t version = 0;
    Kind kind = Kind::placed;
    SessionId session = 0;
    std::size_t point = 0;
    const TileIndex* tile = nullptr;
  };

  static bool shortened(Path& path, std::uint64_t keyframes);
  bool settle(const Component& component, const std::map<SessionId, std::uint64_t>& durable);
  static bool moved_away(const Path& path, const Pose& T_component_session);
  void place(Path& path, const Pose& T_component_session);
  void add_point(Path& path, const PlacedKeyframe& keyframe);
  void draw(SessionId id, const Path& path, const Keyframe& keyframe);
  void number_tiles();
  void add_placed(std::uint64_t version, std::vector<Item>& items) const;
  std::optional<Piece> piece_of(std::vector<Item> items, std::size_t page_bytes) const;
  std::size_t add(const Item& item, Piece& piece) const;

  const std::size_t most_tiles_;
  std::uint64_t version_ = 1, redrawn_ = 0;
  std::map<SessionId, Path> paths_;
  CoverageGrid grid_;
  struct Tile {
    std::uint64_t version = 0;
    std::string encoded;
  };
  std::map<TileIndex, Tile> told_;
};

}  // namespace headframe
