#pragma once
// The clouds of a session, thinned for display, in blocks that clients can fetch one after another and keep.

#include <array>
#include <atomic>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <unordered_set>

#include "server/operator/body_source.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// Edge length of the cubes that hold one point each, by level of detail.
constexpr std::array<double, 5> level_cube_m{2, 1, 0.5, 0.25, 0.1};

/// One session at one level. Blocks are only appended, so blocks that a client has stay valid: a later block has no
/// point in a cube that an earlier one has filled. A block is little-endian: u32 keyframe, u32 number of points, f32 x,
/// y, z of the sensor in the session's frame (m), then for each point i16 x, y, z relative to that, in units of 5 mm.
/// Thread safe.
class PointTile {
 public:
  PointTile(const Station& station, SessionId session, std::size_t level, std::uint64_t moves = 0)
      : station_(station), session_(session), cube_m_(level_cube_m.at(level)), moves_(moves) {}

  /// Block `index`, made from the stored clouds if necessary; nullopt: there are not so many yet. Blocks on the disk.
  Result<std::optional<std::string>> block(std::size_t index);
  /// Approximate memory use; never waits.
  std::size_t bytes() const { return bytes_; }
  /// The newest keyframe that has a block; never waits.
  std::uint64_t newest() const { return newest_; }
  /// How often the poses of the session's earlier keyframes had been changed when this tile was created.
  std::uint64_t moves() const { return moves_; }

 private:
  Result<bool> make_block();
  std::string encoded(const Keyframe& keyframe, const KeyframeCloud& cloud);

  const Station& station_;
  const SessionId session_;
  const double cube_m_;
  const std::uint64_t moves_;
  std::mutex mutex_;
  std::vector<Keyframe> keyframes_;  // as read most recently
  std::size_t at_ = 0;               // index in keyframes_
  std::unordered_set<std::uint64_t> done_, filled_;
  std::vector<std::string> blocks_;
  std::atomic<std::size_t> bytes_ = 0;
  std::atomic<std::uint64_t> newest_ = 0;
};

/// A cache of the most recently used tiles, limited to most_bytes. Thread safe.
class PointTiles {
 public:
  explicit PointTiles(const Station& station, std::size_t most_bytes = 256UL << 20)
      : station_(station), most_bytes_(most_bytes) {}

  /// The tile of this session and level. A new one is made if the cached one has blocks beyond `keyframes` (a session
  /// that was split is shorter), or if the session's earlier keyframes were moved since (`moves`).
  std::shared_ptr<PointTile> tile(SessionId session, std::size_t level, std::uint64_t keyframes,
                                  std::uint64_t moves = 0);
  /// Whether this tile has blocks in memory.
  bool has(SessionId session, std::size_t level);

 private:
  struct Entry {
    std::pair<SessionId, std::size_t> key;
    std::shared_ptr<PointTile> tile;
  };
  const Station& station_;
  const std::size_t most_bytes_;
  std::mutex mutex_;
  std::list<Entry> entries_;  // the most recently used one is first
};

/// Blocks from `first` on, one per piece, until at least `most_points` are sent or there are no more.
class PointStream : public BodySource {
 public:
  PointStream(std::shared_ptr<PointTile> tile, std::size_t first, std::size_t most_points)
      : tile_(std::move(tile)), next_(first), left_(most_points) {}
  Result<std::optional<std::string>> next() override;

 private:
  std::shared_ptr<PointTile> tile_;
  std::size_t next_, left_;
};

}  // namespace headframe
