#include <Eigen/Core>
#include <algorithm>

#include "server/place/descriptor_index.hpp"

namespace headframe {
namespace {

class ExactIndex : public DescriptorIndex {
 public:
  explicit ExactIndex(std::size_t q_size) : q_size_(q_size) {}

  void add(const KeyframeRef& keyframe, const std::vector<float>& q) override {
    values_.insert(values_.end(), q.begin(), q.end());
    keyframes_.push_back(keyframe);
  }

  std::vector<PlaceNeighbour> nearest(const std::vector<float>& q, std::size_t k) const override {
    const Eigen::Map<const Eigen::VectorXf> query(q.data(), static_cast<Eigen::Index>(q.size()));
    std::vector<std::pair<float, std::size_t>> distances(keyframes_.size());
    for (std::size_t i = 0; i < keyframes_.size(); ++i) {
      const Eigen::Map<const Eigen::VectorXf> row(values_.data() + i * q_size_, static_cast<Eigen::Index>(q_size_));
      distances[i] = {(row - query).squaredNorm(), i};
    }
    const std::size_t n = std::min(k, distances.size());
    std::partial_sort(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(n), distances.end());
    std::vector<PlaceNeighbour> out;
    for (std::size_t i = 0; i < n; ++i) out.push_back({keyframes_[distances[i].second], distances[i].first});
    return out;
  }

  std::size_t size() const override { return keyframes_.size(); }

 private:
  std::size_t q_size_;
  std::vector<float> values_;
  std::vector<KeyframeRef> keyframes_;
};

}  // namespace

std::unique_ptr<DescriptorIndex> make_exact_index(std::size_t q_size) { return std::make_unique<ExactIndex>(q_size); }

}  // namespace headframe
