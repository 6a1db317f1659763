#pragma once

#include <set>
#include <string>

#include "server/operator/body_source.hpp"
#include "server/operator/event_diff.hpp"
#include "server/operator/point_tiles.hpp"

namespace headframe {

/// What a first picture needs, in one answer: parts, each after its length in bytes (u32, little-endian). The snapshot
/// event comes first; then of each session in its order the keyframes as PathJson, and the first points as PointStream.
class Overview : public BodySource {
 public:
  /// most_points: of each session that has points. To read the clouds of a thousand sessions takes minutes: points have
  /// those whose tiles are in memory, and of the others those that are connected and then the newest, while they have
  /// no more than most_clouds together. Paths are thinned by path_tolerance_m (thin_path.hpp).
  Overview(const Station& station, PointTiles& tiles, std::size_t level, std::size_t most_points,
           double path_tolerance_m = 0, std::size_t most_clouds = 2000)
      : station_(station),
        tiles_(tiles),
        level_(level),
        most_points_(most_points),
        path_tolerance_m_(path_tolerance_m),
        most_clouds_(most_clouds) {}

  /// One session for each call.
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
  std::optional<StationLook> look_;  // when the answer began
  std::size_t at_ = 0;
};

}  // namespace headframe
