#pragma once
// A plan of a component: a top view without the roof, to scale, on white paper.

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
  int scale = 0;  // 1:scale; 0: the largest usual one that fits A3
  /// Only points between these heights in the frame are shown.
  double low_m = -std::numeric_limits<double>::infinity(), high_m = std::numeric_limits<double>::infinity();
  double pixel_mm = 0.127;  // minimum size of a pixel on paper: 200 per inch
};

/// Reads every cloud twice, one per call: to find the area, and to draw. The paper holds every point that is shown.
/// Points more than half a metre above the sensor are the roof, and are not shown.
class Plan : public BodySource {
 public:
  Plan(const Station& station, const PlanRequest& request) : station_(station), request_(request) {}

  /// not_found: no such component, no survey for the grid, or no keyframe yet; invalid_argument: the plan does not fit
  /// the largest paper.
  Result<std::optional<std::string>> next() override;

 private:
  enum class Stage { begin, measure, choose, paint, write, done };

  Result<void> begin();
  Result<void> choose();
  /// Calls `take` with each point of the keyframe that is shown, in the output frame.
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
  std::vector<std::uint16_t> counts_;    // number of points of each pixel
  std::vector<std::uint16_t> sessions_;  // session of the last point drawn in each pixel
};

}  // namespace headframe
