#pragma once

#include <span>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// How alike the place vectors are where one path lies on the other: for each of b's keyframes that comes within 3 m of
/// one of a's, 1 less the squared distance of the two, in units of that between any two of the sessions (the median);
/// 0 at least. At right placements of learned .68 to .97 (most above .8), at wrong ones mostly .2 to .75; copies reach
/// .97.
struct Agreement {
  double sum = 0, count = 0;

  double mean() const { return count > 0 ? sum / count : 0; }
  /// The mean with one more keyframe that is half alike: few say little, none says 0.5.
  double cautious() const { return (sum + 0.5) / (count + 1); }
  /// Grows with the overlap where more is alike than not.
  double support() const { return sum - 0.5 * count; }
};

/// A spot in a's frame about which keyframes say nothing: the mine looks different there since.
struct Unlike {
  Eigen::Vector3d p_a = Eigen::Vector3d::Zero();
  double reach_m = 0;
};

enum class Heights { as_placed, any };  // any: keyframes meet whatever lies between their heights

/// Compares the descriptors of two sessions under placements. One neighbour among thousands is easily a look-alike; a
/// whole stretch of path is not. Holds views of the keyframes; thread safe.
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
  const Spot* nearest(const Eigen::Vector3f& p, Heights heights) const;  // of a's, within 3 m

  std::vector<Spot> a_, b_;
  float usual_ = 0;
  // Seen from above, a's spots lie in cells of 3 m or more, row by row: those of cell i are [cells_[i], cells_[i + 1]).
  Eigen::Vector2f low_ = Eigen::Vector2f::Zero();
  float cell_m_ = 0;
  Eigen::Index columns_ = 0, rows_ = 0;
  std::vector<std::size_t> cells_;
};

}  // namespace headframe
