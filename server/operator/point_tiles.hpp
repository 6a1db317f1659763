#pragma once
// The clouds of a session, thinned for a view, in blocks that may be fetched one after another and kept.

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

/// Edge of a cube that holds one point, by level of detail.
constexpr std::array<double, 5> level_cube_m{2, 1, 0.5, 0.25, 0.1};

/// One session at one level. Blocks only ever come to the end, so what a client has stays right: a cube that an earlier
/// block has filled is left out of later ones. A block, little-endian: u32 keyframe, u32 points, f32 x, y, z of the
/// sensor in the session's frame (m), then for each point i16 x, y, z from there in units of 5 mm. Thread safe.
class PointTile {
 public:
  PointTile(const Station& station, SessionId session, std::size_t level, std::uint64_t moves = 0)
      : station_(station), session_(session), cube_m_(level_cube_m.at(level)), moves_(moves) {}

  /// Block `index`, made from the stored clouds when it is not there yet; none: there are no more now. Blocks the disk.
  Result<std::optional<std::string>> block(std::size_t index);
  /// Of memory, about; never waits.
  std::size_t bytes() const { return bytes_; }
  /// The newest keyframe of which there is a block; never waits.
  std::uint64_t newest() const { return newest_; }
  /// How often the session's past had been moved when it was begun.
  std::uint64_t moves() const { return moves_; }

 private:
  Result<bool> make_block();
  std::string encoded(const Keyframe& keyframe, const KeyframeCloud& cloud);

  const Station& station_;
  const SessionId session_;
  const double cube_m_;
  const std::uint64_t moves_;
  std::mutex mutex_;
  std::vector<Keyframe> keyframes_;  // as read last
  std::size_t at_ = 0;               // in keyframes_
  std::unordered_set<std::uint64_t> done_, filled_;
  std::vector<std::string> blocks_;
  std::atomic<std::size_t> bytes_ = 0;
  std::atomic<std::uint64_t> newest_ = 0;
};

/// The tiles asked for last, as many as fit most_bytes. Thread safe.
class PointTiles {
 public:
  explicit PointTiles(const Station& station, std::size_t most_bytes = 256UL << 20)
      : station_(station), most_bytes_(most_bytes) {}

  /// Begun anew where it holds more than the session's keyframes, for a session that was split has become shorter, and
  /// where its past was moved since.
  std::shared_ptr<PointTile> tile(SessionId session, std::size_t level, std::uint64_t keyframes,
                                  std::uint64_t moves = 0);
  /// Whether blocks of it are in memory.
  bool has(SessionId session, std::size_t level);

 private:
  struct Entry {
    std::pair<SessionId, std::size_t> key;
    std::shared_ptr<PointTile> tile;
  };
  const Station& station_;
  const std::size_t most_bytes_;
  std::mutex mutex_;
  std::list<Entry> entries_;  // the one asked for last is first
};

/// Blocks from `first` on, one for each piece, until `most_points` are sent or there are no more.
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
