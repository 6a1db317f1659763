#pragma once

#include "common/descriptor/family.hpp"

namespace headframe {

/// LiDAR-Iris (Wang et al., IROS 2020), reduced to what is sent. The scan becomes an image seen from above: 80 rings x
/// 360 sectors, each cell a byte whose bits say which of 8 height layers contain a point. Four LoG-Gabor filters run
/// along each ring. q holds, for each filter and 20 groups of rings, the root mean square of the response (independent
/// of yaw). w holds, for every 5 deg of azimuth, the share of bits set in the thresholded responses, which are the
/// paper's binary image (shifts with yaw). Deviations: the binary image itself is not sent, so places are compared by q
/// and not by a Hamming distance; ring widths grow by 6 % each from 0.5 to 60 m, and layers are 0.75 m around the
/// sensor, because tunnels are 3 to 10 m wide and have a roof.
class LidarIris : public DescriptorFamily {
 public:
  FamilyId id() const override { return {"lidar_iris", 1}; }
  std::size_t q_size() const override { return 80; }
  std::size_t w_size() const override { return 72; }
  Result<Descriptor> extract(const Points& points_level) const override;
};

}  // namespace headframe
