#pragma once
// A component's plan: seen from above with the roof cut off, as a PNG picture.

#include <Eigen/Core>

#include "server/operator/body_source.hpp"
#include "server/operator/placed_component.hpp"

namespace headframe {

/// Sessions coloured; lines of the frame's coordinates, an arrow to its north (y), a scale bar. Reads one cloud for
/// each call and keeps only the picture. Points more than half a metre above the sensor are the roof.
class PlanPng : public BodySource {
 public:
  PlanPng(const Station& station, SessionId component, OutputFrame frame)
      : station_(station), component_(component), frame_(frame) {}

  /// not_found: no such component, no survey, or no keyframe yet.
  Result<std::optional<std::string>> next() override;

 private:
  /// From metres in the frame to pixels of the map.
  struct Sheet {
    Eigen::Vector2d low_m = Eigen::Vector2d::Zero();
    double px_per_m = 1;
    int width_px = 0, height_px = 0;
    Eigen::Vector2d px(const Eigen::Vector2d& p_m) const {
      return {(p_m.x() - low_m.x()) * px_per_m, height_px - (p_m.y() - low_m.y()) * px_per_m};
    }
  };

  Result<void> begin();
  Result<void> add(const PlacedKeyframe& keyframe);
  Result<std::string> picture() const;

  const Station& station_;
  const SessionId component_;
  const OutputFrame frame_;
  bool begun_ = false, done_ = false;
  PlacedComponent placed_;
  std::size_t at_ = 0;
  Sheet sheet_;
  std::vector<float> counts_;            // of points, by pixel
  std::vector<Eigen::Array3f> colours_;  // summed over the points, by pixel
};

}  // namespace headframe
