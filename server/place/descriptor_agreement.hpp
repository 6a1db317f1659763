#pragma once

#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Whether the descriptors of two sessions agree where a placement lays one path on the other. One neighbour among
/// thousands is easily a look-alike; a whole stretch of path is not. Holds views of the keyframes; thread safe.
class DescriptorAgreement {
 public:
  DescriptorAgreement(std::span<const Keyframe> a, std::span<const Keyframe> b);

  /// 0 to 1: the mean, over b's keyframes that come within 3 m of one of a's, of 1 less the squared distance of the two
  /// place vectors, in units of that between any two of the sessions (the median). One more counts a half, so that few
  /// say little and none says 0.5. At the right placement of learned some .8 to .95, elsewhere .2 to .6.
  double at(const Pose& T_a_b) const;

  /// Sum over the same keyframes, each from 0.5 (alike) to -0.5 (as unlike as any two): grows with the overlap.
  double support(const Pose& T_a_b) const;

 private:
  struct Spot {
    Eigen::Vector3f place;
    const std::vector<float>* q;
  };
  struct Sum {
    double alike = 0, count = 0;
  };
  Sum sum(const Pose& T_a_b) const;
  static std::vector<Spot> spots(std::span<const Keyframe> keyframes, std::size_t q_size);

  std::vector<Spot> a_, b_;
  float usual_ = 0;
};

}  // namespace headframe
