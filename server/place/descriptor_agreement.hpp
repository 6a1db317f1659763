#pragma once

#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// How similar the place vectors are along the overlap. For each keyframe of b within 3 m of one of a's: 1 minus the
/// squared distance of their place vectors divided by the median squared distance between the two sessions; 0 at least.
/// With `learned` the mean is .68 to .97 at right placements (mostly above .8) and mostly .2 to .75 at wrong ones;
/// copies reach .97.
struct Agreement {
  double sum = 0, count = 0;

  double mean() const { return count > 0 ? sum / count : 0; }
  /// The mean with so many more keyframes of similarity 0.5, because few keyframes say little; 0.5 if there are none.
  double cautious(double more = 1) const { return (sum + 0.5 * more) / (count + more); }
  /// Grows with the overlap if the mean is above 0.5.
  double support() const { return sum - 0.5 * count; }
};

/// A spot in a's frame around which keyframes are not compared, because the mine has changed there.
struct Unlike {
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero();
  double reach_m = 0;
};

enum class Heights { as_placed, any };  // any: keyframes are compared whatever their difference in height

/// Compares the descriptors of two sessions under given placements. A single similar keyframe among thousands is easily
/// a look-alike; a whole stretch of path is not. The keyframes must outlive this object. Thread safe.
class DescriptorAgreement {
 public:
  DescriptorAgreement(std::span<const Keyframe> a, std::span<const Keyframe> b);

  Agreement at(const Pose& T_a_b, Heights heights = Heights::as_placed, std::span<const Unlike> without = {}) const;

 private:
  struct Spot {
    Eigen::Vector3f place;
    const std::vector<float>* q;
  };
  static std::vector<Spot> spots(std::span<const Keyframe> keyframes, std::size_t q_size);
  void sort_into_cells();
  const Spot* nearest(const Eigen::Vector3f& p, Heights heights) const;  // the nearest of a's within 3 m

  std::vector<Spot> a_, b_;
  float usual_ = 0;
  // Seen from above, a's spots are sorted into cells of 3 m or more, row by row; those of cell i are [cells_[i],
  // cells_[i + 1]).
  Eigen::Vector2f low_ = Eigen::Vector2f::Zero();
  float cell_m_ = 0;
  Eigen::Index columns_ = 0, rows_ = 0;
  std::vector<std::size_t> cells_;
};

}  // namespace headframe
