#include "server/atlas/correction.hpp"

#include <algorithm>

namespace headframe {

Pose Correction::corrected(std::uint64_t sequence, const Pose& T_local_sensor) const {
  const auto after = std::upper_bound(keyframes.begin(), keyframes.end(), sequence,
                                      [](std::uint64_t s, const CorrectedKeyframe& k) { return s < k.sequence; });
  if (after == keyframes.begin()) return keyframes.front().T_component_session * T_local_sensor;
  const CorrectedKeyframe& before = *(after - 1);
  Pose T_before = before.T_component_session * T_local_sensor;
  if (after == keyframes.end() || before.sequence == sequence) return T_before;
  const Pose T_after = after->T_component_session * T_local_sensor;
  const double share =
      static_cast<double>(sequence - before.sequence) / static_cast<double>(after->sequence - before.sequence);
  const Eigen::Quaterniond q(T_before.rotation());
  Pose T = Pose::Identity();
  T.linear() = q.slerp(share, Eigen::Quaterniond(T_after.rotation())).toRotationMatrix();
  T.translation() = (1 - share) * T_before.translation() + share * T_after.translation();
  return T;
}

}  // namespace headframe
