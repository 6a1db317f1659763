#pragma once
// What robots may be told of what others know: one ComponentMap for each component that is asked for.

#include <atomic>
#include <chrono>
#include <list>

#include "server/store/store.hpp"
#include "server/surroundings/component_map.hpp"
#include "server/surroundings/map_region.hpp"

namespace headframe {

/// The component of one session as the atlas has it now.
struct SessionSurroundings {
  SessionId receiver = 0;  // who asks
  std::uint64_t revision = 0;
  Component component;
  std::map<SessionId, SessionKey> keys;
  std::map<SessionId, std::uint64_t> durable;     // keyframes
  std::map<SessionId, std::uint64_t> moves = {};  // how often keyframes were moved, of those whose were
};

/// Reads the disk: not for an I/O thread. All calls from one thread at a time, but stop(), which is for any.
class ComponentMaps {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `first_epoch` must differ from that of an earlier run: drawn at random.
  ComponentMaps(Store& store, std::uint64_t first_epoch, const MapLimits& limits = {})
      : store_(store), next_epoch_(first_epoch), limits_(limits) {}

  struct Known {
    ComponentMap* map = nullptr;
    std::uint64_t epoch = 0;
  };
  /// Up to date; a map that was not asked for lately makes room. unavailable: too many are.
  Result<Known> refreshed(const SessionSurroundings& around, Time now);

  struct MapAnswer {
    std::string encoded;                                 // common/cloud/cloud_codec.hpp; empty: no points
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // in the receiver's frame
    std::size_t points = 0, clouds = 0, clouds_left_out = 0;
    bool since = false;
    HeldVersion held;
  };
  /// The region is in the local frame of who asks. invalid_argument: too much, and what to do.
  Result<MapAnswer> map_of(const SessionSurroundings& around, const Region& region, double resolution_m,
                           const HeldVersion& since, Time now);

  /// What runs ends soon, and so does all that is asked for later.
  void stop() { stopping_ = true; }

  static constexpr std::size_t most_maps = 16;
  static constexpr std::size_t most_tiles = 8192;  // of one map: some 180 km of tunnel, 100 MiB
  static constexpr auto kept = std::chrono::minutes(10);

 private:
  struct Entry {
    SessionId component = 0;
    std::uint64_t epoch = 0;
    Time asked;
    ComponentMap map{most_tiles};
  };

  Store& store_;
  std::uint64_t next_epoch_;
  const MapLimits limits_;
  std::atomic<bool> stopping_ = false;
  std::list<Entry> entries_;
};

}  // namespace headframe
