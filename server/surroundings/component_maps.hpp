#pragma once
// What robots can be told about what others know: one ComponentMap for each component that is asked about.

#include <atomic>
#include <chrono>
#include <list>

#include "server/store/store.hpp"
#include "server/surroundings/component_map.hpp"
#include "server/surroundings/map_region.hpp"

namespace headframe {

/// The component of one session in the present atlas.
struct SessionSurroundings {
  SessionId receiver = 0;  // the session that asks
  std::uint64_t revision = 0;
  Component component;
  std::map<SessionId, SessionKey> keys;
  std::map<SessionId, std::uint64_t> durable;     // number of durable keyframes
  std::map<SessionId, std::uint64_t> moves = {};  // how often keyframes were moved, for sessions in which some were
};

/// Reads from the disk, so not for an I/O thread. Call from one thread at a time, except stop(), which any thread may
/// call.
class ComponentMaps {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `first_epoch` is random, so that it differs from that of earlier runs.
  ComponentMaps(Store& store, std::uint64_t first_epoch, const MapLimits& limits = {})
      : store_(store), next_epoch_(first_epoch), limits_(limits) {}

  struct Known {
    ComponentMap* map = nullptr;
    std::uint64_t epoch = 0;
  };
  /// The up-to-date map of the component; one that was not used lately is discarded if necessary. unavailable: too many
  /// are in use.
  Result<Known> refreshed(const SessionSurroundings& around, Time now);

  struct MapAnswer {
    std::string encoded;                                 // common/cloud/cloud_codec.hpp; empty: no points
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // in the receiver's local frame
    std::size_t points = 0, clouds = 0, clouds_left_out = 0;
    bool since = false;
    HeldVersion held;
  };
  /// The region is in the receiver's local frame. invalid_argument: the request is too large; the message says what to
  /// do.
  Result<MapAnswer> map_of(const SessionSurroundings& around, const Region& region, double resolution_m,
                           const HeldVersion& since, Time now);

  /// Ends the running call soon, and makes later ones end at once.
  void stop() { stopping_ = true; }

  static constexpr std::size_t most_maps = 16;
  static constexpr std::size_t most_tiles = 8192;  // for one map: some 180 km of tunnel, 100 MiB
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
