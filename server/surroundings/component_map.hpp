#pragma once
// Paths and coverage of one component, so numbered that whoever holds a version can be told what is newer.

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

/// Where keyframes are read; as Store::each_keyframe.
using ReadKeyframes = std::function<Result<void>(SessionId, std::uint64_t, const std::function<void(Keyframe)>&)>;

/// Path points as they travel: the component's frame in units of path_unit_m.
inline constexpr double path_unit_m = 0.1;
using PathPoint = std::array<std::int32_t, 3>;

/// Everything that was ever told has a version; versions only go up. A page is all that is newer than a version, up to
/// another. Not thread safe.
class ComponentMap {
 public:
  explicit ComponentMap(std::size_t most_tiles) : most_tiles_(most_tiles), grid_(most_tiles) {}

  /// Reads what is new: keyframes beyond those that were read, of sessions that `durable` says have more. A session
  /// that came to lie elsewhere by more than moved_m, or left, has all drawn anew. `stop` is asked between keyframes:
  /// true leaves the rest out. The first failure to read is returned; all else is drawn.
  Result<void> refresh(const Component& component, const std::map<SessionId, std::uint64_t>& durable,
                       const ReadKeyframes& read, const std::function<bool()>& stop);

  /// The session's keyframes were moved so often: when that is news they are read anew by the next refresh().
  void moved(SessionId session, std::uint64_t moves);

  struct PathPiece {
    SessionId session = 0;
    std::size_t first = 0;          // points of the path before these
    std::optional<PathPoint> last;  // of those
    std::vector<PathPoint> points;
    bool gone = false;
  };
  struct Piece {  // of all that is newer than a version, up to this one
    std::uint64_t version = 0;
    bool more = false;
    std::vector<SessionId> placed = {};  // came to lie where they do
    std::vector<PathPiece> paths = {};
    std::vector<std::pair<TileIndex, std::string>> tiles = {};  // encoded
  };
  /// What `receiver` is to be told of the other sessions' paths after `version`, about page_bytes of it. nullopt:
  /// nothing.
  std::optional<Piece> paths_after(std::uint64_t version, SessionId receiver, std::size_t page_bytes) const;
  /// The same of the coverage, which is all sessions'.
  std::optional<Piece> coverage_after(std::uint64_t version, std::size_t page_bytes) const;

  struct PlacedKeyframe {
    std::uint64_t sequence = 0;
    double stamp_s = 0;
    Pose T_local_sensor = Pose::Identity();
  };
  /// What was read of a session; null: it is not in the component.
  const std::vector<PlacedKeyframe>* keyframes(SessionId session) const;
  double last_stamp_s(SessionId session) const;

  /// Versions of clouds: `sequences` are all there are now, and those not seen before, or of a session that moved, get
  /// a new one.
  void note_clouds(SessionId session, const std::vector<std::uint64_t>& sequences);
  std::uint64_t cloud_version(SessionId session, std::uint64_t sequence) const;

  /// The version in which what had been drawn last moved or went; 0: it never did.
  std::uint64_t redrawn() const { return redrawn_; }
  /// The newest version there is.
  std::uint64_t version() const { return version_; }
  /// Not all was drawn: more tiles than may be.
  bool full() const { return grid_.full(); }
  std::size_t tiles() const { return grid_.tiles().size(); }

  static constexpr double moved_m = 0.25;       // at any keyframe of its path: less is not worth to be told
  static constexpr double point_every_m = 2;    // of a path
  static constexpr double longest_step_m = 15;  // between keyframes: beyond, nobody walked straight

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
    std::uint64_t placed = 0, left = 0;             // the versions in which it was, or did
    bool gone = false;
    std::uint64_t moves = 0;  // of its keyframes, as they were read
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
