#pragma once

#include <set>
#include <string>

#include "server/operator/body_source.hpp"
#include "server/operator/event_diff.hpp"
#include "server/operator/point_tiles.hpp"

namespace headframe {

/// All data for a first picture in one response. It consists of parts; each begins with its length in bytes (u32,
/// little-endian). The first part is the snapshot event. Two parts follow for each session, in its order: its keyframes
/// as PathJson, and its first points as PointStream.
class Overview : public BodySource {
 public:
  /// most_points: for each session that gets points. Reading the clouds of a thousand sessions takes minutes, so not
  /// all sessions get points: those whose tiles are in memory do, and of the others first the connected ones and then
  /// the newest, as long as they have no more than most_clouds clouds together. Paths are thinned by path_tolerance_m
  /// (thin_path.hpp).
  Overview(const Station& station, PointTiles& tiles, std::size_t level, std::size_t most_points,
           double path_tolerance_m = 0, std::size_t most_clouds = 2000)
      : station_(station),
        tiles_(tiles),
        level_(level),
        most_points_(most_points),
        path_tolerance_m_(path_tolerance_m),
        most_clouds_(most_clouds) {}

  /// Handles one session per call.
  Result<std::optional<std::string>> next() override;

 private:
  void choose_sessions();
  Result<std::string> session(SessionId id) const;

  const Station& station_;
  PointTiles& tiles_;
  const std::size_t level_, most_points_;
  const double path_tolerance_m_;
  const std::size_t most_clouds_;
  std::set<SessionId> with_points_;
  std::optional<StationLook> look_;  // taken when the response began
  std::size_t at_ = 0;
};

}  // namespace headframe
