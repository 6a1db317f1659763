#include <flann/flann.hpp>

#include "server/place/descriptor_index.hpp"

namespace headframe {
namespace {

constexpr int trees = 4;
constexpr int checks = 256;

class FlannIndex : public DescriptorIndex {
 public:
  explicit FlannIndex(std::size_t q_size) : q_size_(q_size) {}

  void add(const KeyframeRef& keyframe, const std::vector<float>& q) override {
    rows_.push_back(std::make_unique<float[]>(q_size_));  // FLANN keeps pointers into our rows: they may not move
    std::copy(q.begin(), q.end(), rows_.back().get());
    keyframes_.push_back(keyframe);
    const flann::Matrix<float> row(rows_.back().get(), 1, q_size_);
    if (!index_) {
      flann::seed_random(1);
      index_ = std::make_unique<Index>(row, flann::KDTreeIndexParams(trees));
      index_->buildIndex();
    } else {
      index_->addPoints(row, 2.0F);
    }
  }

  std::vector<PlaceNeighbour> nearest(const std::vector<float>& q, std::size_t k) const override {
    if (!index_) return {};
    std::vector<float> copy = q;
    const flann::Matrix<float> query(copy.data(), 1, q_size_);
    std::vector<std::vector<std::size_t>> indices;
    std::vector<std::vector<float>> distances;
    index_->knnSearch(query, indices, distances, std::min(k, size()), flann::SearchParams(checks));
    std::vector<PlaceNeighbour> out;
    for (std::size_t i = 0; i < indices[0].size(); ++i) out.push_back({keyframes_[indices[0][i]], distances[0][i]});
    return out;
  }

  /// One after another, whatever the threads.
  std::vector<std::vector<PlaceNeighbour>> nearest_of_each(std::span<const std::span<const float>> qs, std::size_t k,
                                                           int /*threads*/) const override {
    std::vector<std::vector<PlaceNeighbour>> out;
    out.reserve(qs.size());
    for (const auto& q : qs) out.push_back(nearest({q.begin(), q.end()}, k));
    return out;
  }

  std::size_t size() const override { return keyframes_.size(); }

 private:
  using Index = flann::Index<flann::L2<float>>;
  std::size_t q_size_;
  std::vector<std::unique_ptr<float[]>> rows_;
  std::vector<KeyframeRef> keyframes_;
  std::unique_ptr<Index> index_;
};

}  // namespace

std::unique_ptr<DescriptorIndex> make_flann_index(std::size_t q_size) { return std::make_unique<FlannIndex>(q_size); }

}  // namespace headframe
