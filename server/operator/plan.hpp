#pragma once
// A component's plan: seen from above with the roof cut off, to scale on white paper.

#include <Eigen/Geometry>

#include "server/operator/body_source.hpp"
#include "server/operator/placed_component.hpp"
#include "server/operator/plan_layout.hpp"

namespace headframe {

enum class PlanFormat { png, svg, pdf };

struct PlanRequest {
  SessionId component = 0;
  OutputFrame frame = OutputFrame::component;
  PlanFormat format = PlanFormat::png;
  int scale = 0;  // 1:scale; 0: what fits A3
  /// Heights in the frame between which points are shown.
  double low_m = -std::numeric_limits<double>::infinity(), high_m = std::numeric_limits<double>::infinity();
  double pixel_mm = 0.127;  // of paper, at least: 200 to the inch
};

/// Reads every cloud twice, one for each call: for what the paper has to hold, and for the picture. Every point that is
/// shown is on the paper. Points more than half a metre above the sensor are the roof.
class Plan : public BodySource {
 public:
  Plan(const Station& station, const PlanRequest& request) : station_(station), request_(request) {}

  /// not_found: no such component, no survey, or no keyframe yet; invalid_argument: it does not fit the largest paper.
  Result<std::optional<std::string>> next() override;

 private:
  enum class Stage { begin, measure, choose, paint, write, done };

  Result<void> begin();
  Result<void> choose();
  /// Calls `take` with each point that is shown, in the frame.
  template <class Take>
  Result<void> each_point(const PlacedKeyframe& keyframe, Take take) const;
  void paint(const Eigen::Vector3d& p_m, std::size_t session);
  picture::SheetPicture picture() const;
  PlanWords words() const;
  Result<std::string> written() const;

  const Station& station_;
  const PlanRequest request_;
  Stage stage_ = Stage::begin;
  PlacedComponent placed_;
  std::size_t at_ = 0;
  Eigen::AlignedBox2d box_m_;
  PlanPaper paper_;
  double mm_per_px_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint16_t> counts_;    // of points, by pixel
  std::vector<std::uint16_t> sessions_;  // the one that was there last, by pixel
};

}  // namespace headframe
