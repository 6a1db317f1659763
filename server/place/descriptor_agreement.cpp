#include "server/place/descriptor_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace headframe {
namespace {

constexpr float near_m = 3;
constexpr float most_cells = 512;     // along either axis
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
  if (a_.empty() || b_.empty()) return;
  std::vector<float> distances;
  distances.reserve(4 * compared * compared);
  for (std::size_t i = 0; i < a_.size(); i += 1 + a_.size() / compared)
    for (std::size_t j = 0; j < b_.size(); j += 1 + b_.size() / compared)
      distances.push_back(squared_distance(*a_[i].q, *b_[j].q));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  usual_ = *middle;
  sort_into_cells();
}

void DescriptorAgreement::sort_into_cells() {
  Eigen::Vector2f high = low_ = a_.front().place.head<2>();
  for (const Spot& spot : a_) {
    low_ = low_.cwiseMin(spot.place.head<2>());
    high = high.cwiseMax(spot.place.head<2>());
  }
  cell_m_ = std::max(near_m, (high - low_).maxCoeff() / most_cells);
  columns_ = static_cast<Eigen::Index>((high.x() - low_.x()) / cell_m_) + 1;
  rows_ = static_cast<Eigen::Index>((high.y() - low_.y()) / cell_m_) + 1;
  const auto cell_of = [&](const Spot& spot) {
    const auto at = ((spot.place.head<2>() - low_) / cell_m_).cast<Eigen::Index>().eval();
    return static_cast<std::size_t>(at.y() * columns_ + at.x());
  };
  std::stable_sort(a_.begin(), a_.end(), [&](const Spot& s, const Spot& t) { return cell_of(s) < cell_of(t); });
  cells_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const Spot& spot : a_) ++cells_[cell_of(spot) + 1];
  std::partial_sum(cells_.begin(), cells_.end(), cells_.begin());
}

const DescriptorAgreement::Spot* DescriptorAgreement::nearest(const Eigen::Vector3f& p, Heights heights) const {
  const Eigen::Vector3f counts(1, 1, heights == Heights::any ? 0 : 1);
  const Eigen::Vector2f at = (p.head<2>() - low_) / cell_m_;
  if (!(at.x() > -1 && at.y() > -1 && at.x() < static_cast<float>(columns_ + 1) &&
        at.y() < static_cast<float>(rows_ + 1)))
    return nullptr;
  const auto x = static_cast<Eigen::Index>(std::floor(at.x())), y = static_cast<Eigen::Index>(std::floor(at.y()));
  const Eigen::Index left = std::max<Eigen::Index>(x - 1, 0), right = std::min(x + 1, columns_ - 1);
  float least = near_m * near_m;
  const Spot* found = nullptr;
  for (Eigen::Index row = std::max<Eigen::Index>(y - 1, 0); row <= std::min(y + 1, rows_ - 1); ++row) {
    if (left > right) break;
    const std::size_t begin = cells_[static_cast<std::size_t>(row * columns_ + left)],
                      end = cells_[static_cast<std::size_t>(row * columns_ + right) + 1];
    for (std::size_t i = begin; i < end; ++i) {
      const float squared = (a_[i].place - p).cwiseProduct(counts).squaredNorm();
      if (squared >= least) continue;
      least = squared;
      found = &a_[i];
    }
  }
  return found;
}

Agreement DescriptorAgreement::at(const Pose& T_a_b, Heights heights, std::span<const Unlike> without) const {
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  Agreement out;
  if (!(usual_ > 0)) return out;  // all vectors are equal, so they tell nothing
  for (const Spot& b : b_) {
    const Spot* a = nearest(T * b.place, heights);
    const auto unlike = [&](const Unlike& u) { return (a->place - u.p_a.cast<float>()).norm() < u.reach_m; };
    if (!a || std::any_of(without.begin(), without.end(), unlike)) continue;
    out.sum += std::max(0.0F, 1 - squared_distance(*a->q, *b.q) / usual_);
    out.count += 1;
  }
  return out;
}

}  // namespace headframe
