#pragma once
// Data for a picture of an alignment's evidence: both sessions' points around the overlap, in one frame.

#include "server/operator/body_source.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// JSON, in a's frame, with b placed by the alignment's T_a_b: points "a" and "b" [[x, y, z], ...]; "residuals_m": how
/// many of b's points are 0 to 1, 1 to 2, ... times "bin_m" from a's surface (along its normal); "unmatched": how many
/// have no surface of a within half a metre; "runner_up": the best different placement with its probability, or null.
class OverlayJson : public BodySource {
 public:
  /// most: maximum number of points of each session.
  OverlayJson(const Station& station, Alignment alignment, std::size_t most)
      : station_(station), alignment_(std::move(alignment)), most_(most) {}

  /// not_found: one of the sessions has no stored cloud around the overlap.
  Result<std::optional<std::string>> next() override;

 private:
  const Station& station_;
  const Alignment alignment_;
  const std::size_t most_;
  bool done_ = false;
};

}  // namespace headframe
