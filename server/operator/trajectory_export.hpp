#pragma once

#include <string>

#include "server/operator/body_source.hpp"
#include "server/operator/placed_component.hpp"

namespace headframe {

enum class TrajectoryFormat { tum, csv };

/// A session's keyframes in its component's frame or the mine's grid, in one piece: as TUM text ("stamp x y z qx qy qz
/// qw", s and m) after a comment that names the frame, or as CSV with a header line that names the same columns.
/// not_found: no such robot or session, or no survey; unavailable: the session is not in the atlas yet.
class TrajectoryExport : public BodySource {
 public:
  TrajectoryExport(const Station& station, SessionKey key, TrajectoryFormat format = TrajectoryFormat::tum,
                   OutputFrame frame = OutputFrame::component)
      : station_(station), key_(std::move(key)), format_(format), frame_(frame) {}
  Result<std::optional<std::string>> next() override;

 private:
  Result<std::string> text() const;

  const Station& station_;
  SessionKey key_;
  TrajectoryFormat format_;
  OutputFrame frame_;
  bool done_ = false;
};

/// Keyframes from sequence `first` on, in the session's own frame, as JSON: {"columns": [...], "keyframes": [[...],
/// ...]}. With a tolerance, only those that thin_path() keeps.
class PathJson : public BodySource {
 public:
  PathJson(const Station& station, SessionId session, std::uint64_t first, double tolerance_m = 0)
      : station_(station), session_(session), first_(first), tolerance_m_(tolerance_m) {}
  Result<std::optional<std::string>> next() override;

 private:
  const Station& station_;
  SessionId session_;
  std::uint64_t first_;
  double tolerance_m_;
  bool done_ = false;
};

}  // namespace headframe
