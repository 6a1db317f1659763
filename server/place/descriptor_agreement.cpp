#include "server/place/descriptor_agreement.hpp"

#include <algorithm>
#include <cmath>

namespace headframe {
namespace {

constexpr float near_m = 3;
constexpr std::size_t compared = 64;  // spots of each session, evenly spread, for the usual distance

float squared_distance(const std::vector<float>& p, const std::vector<float>& q) {
  float sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += (p[i] - q[i]) * (p[i] - q[i]);
  return sum;
}

}  // namespace

std::vector<DescriptorAgreement::Spot> DescriptorAgreement::spots(std::span<const Keyframe> keyframes,
                                                                  std::size_t q_size) {
  std::vector<Spot> out;
  out.reserve(keyframes.size());
  for (const Keyframe& k : keyframes)
    if (q_size > 0 && k.descriptor.q.size() == q_size)
      out.push_back({k.T_local_sensor.translation().cast<float>(), &k.descriptor.q});
  return out;
}

DescriptorAgreement::DescriptorAgreement(std::span<const Keyframe> a, std::span<const Keyframe> b) {
  const auto first = std::find_if(a.begin(), a.end(), [](const Keyframe& k) { return !k.descriptor.q.empty(); });
  if (first == a.end()) return;
  a_ = spots(a, first->descriptor.q.size());
  b_ = spots(b, first->descriptor.q.size());
  std::vector<float> distances;
  distances.reserve(4 * compared * compared);
  for (std::size_t i = 0; i < a_.size(); i += 1 + a_.size() / compared)
    for (std::size_t j = 0; j < b_.size(); j += 1 + b_.size() / compared)
      distances.push_back(squared_distance(*a_[i].q, *b_[j].q));
  if (distances.empty()) return;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  usual_ = *middle;
}

Agreement DescriptorAgreement::at(const Pose& T_a_b) const {
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  Agreement out;
  if (!(usual_ > 0)) return out;  // all the same: they tell nothing
  for (const Spot& b : b_) {
    const Eigen::Vector3f p = T * b.place;
    float nearest = near_m * near_m;
    const Spot* partner = nullptr;
    for (const Spot& a : a_) {
      const float squared = (a.place - p).squaredNorm();
      if (squared >= nearest) continue;
      nearest = squared;
      partner = &a;
    }
    if (!partner) continue;
    out.sum += std::max(0.0F, 1 - squared_distance(*partner->q, *b.q) / usual_);
    out.count += 1;
  }
  return out;
}

}  // namespace headframe
