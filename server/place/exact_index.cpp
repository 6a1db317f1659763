#include <algorithm>
#include <cstring>
#include <limits>

#include "server/place/descriptor_index.hpp"
#include "server/place/squared_distances.hpp"
#include "server/support/parallel.hpp"
#include "server/support/simd.hpp"

namespace headframe {
namespace {

constexpr std::size_t block_size = 12;  // queries; a ranking asks about 50, which all threads share

Float4 load(const float* p) {
  Float4 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
Float4 smaller(Float4 a, Float4 b) { return a < b ? a : b; }

float least(const float* panel) {
  static_assert(PanelStore::width == 16);
  const Float4 v = smaller(smaller(load(panel), load(panel + 4)), smaller(load(panel + 8), load(panel + 12)));
  return std::min(std::min(v[0], v[1]), std::min(v[2], v[3]));
}

/// A bound that at least k vectors do not exceed: panels are combined to about 2 k groups, and the k-th smallest of the
/// groups' minima is taken. Infinite if there are fewer panels than k.
float bound(const std::vector<float>& least_of_panel, std::size_t k) {
  const std::size_t panels = least_of_panel.size(), together = std::max<std::size_t>(1, panels / (2 * k));
  if (k > panels) return std::numeric_limits<float>::infinity();
  std::vector<float> least_of_group((panels + together - 1) / together, std::numeric_limits<float>::infinity());
  for (std::size_t p = 0; p < panels; ++p)
    least_of_group[p / together] = std::min(least_of_group[p / together], least_of_panel[p]);
  const auto nth = least_of_group.begin() + static_cast<std::ptrdiff_t>(k - 1);
  std::nth_element(least_of_group.begin(), nth, least_of_group.end());
  return *nth;
}

class ExactIndex : public DescriptorIndex {
 public:
  explicit ExactIndex(std::size_t q_size) : store_(q_size) {}

  void add(const KeyframeRef& keyframe, const std::vector<float>& q) override {
    store_.add(q);
    keyframes_.push_back(keyframe);
  }

  std::vector<PlaceNeighbour> nearest(const std::vector<float>& q, std::size_t k) const override {
    const std::span<const float> query(q);
    return std::move(nearest_of_each({&query, 1}, k, 1).front());
  }

  std::vector<std::vector<PlaceNeighbour>> nearest_of_each(std::span<const std::span<const float>> qs, std::size_t k,
                                                           int threads) const override {
    std::vector<std::vector<PlaceNeighbour>> out(qs.size());
    const std::size_t wanted = std::min(k, size());
    if (wanted == 0) return out;
    for_blocks(qs.size(), block_size, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
      std::vector<float> distances;
      store_.distances(qs.subspan(begin, end - begin), distances);
      const std::size_t row = store_.panels() * PanelStore::width;
      for (std::size_t i = begin; i < end; ++i) out[i] = select(distances.data() + (i - begin) * row, qs[i], wanted);
    });
    return out;
  }

  std::size_t size() const override { return keyframes_.size(); }

 private:
  using Candidate = std::pair<float, std::size_t>;

  /// The few candidates for the k nearest are compared again exactly, so that the order does not depend on the
  /// processor.
  std::vector<PlaceNeighbour> select(const float* distances, std::span<const float> q, std::size_t k) const {
    std::vector<float> least_of_panel(store_.panels());
    for (std::size_t p = 0; p < least_of_panel.size(); ++p)
      least_of_panel[p] = least(distances + p * PanelStore::width);
    const float limit = bound(least_of_panel, k) + 2 * store_.rounding_of(q);
    std::vector<Candidate> candidates;
    candidates.reserve(2 * k);
    for (std::size_t p = 0; p < least_of_panel.size(); ++p) {
      if (least_of_panel[p] > limit) continue;
      for (std::size_t i = p * PanelStore::width; i < std::min(size(), (p + 1) * PanelStore::width); ++i)
        if (distances[i] <= limit) candidates.emplace_back(store_.distance(i, q), i);
    }
    std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(k), candidates.end());
    std::vector<PlaceNeighbour> out;
    out.reserve(k);
    for (std::size_t i = 0; i < k; ++i) out.push_back({keyframes_[candidates[i].second], candidates[i].first});
    return out;
  }

  PanelStore store_;
  std::vector<KeyframeRef> keyframes_;
};

}  // namespace

std::unique_ptr<DescriptorIndex> make_exact_index(std::size_t q_size) { return std::make_unique<ExactIndex>(q_size); }

}  // namespace headframe
