#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "server/registration/registration.hpp"

namespace headframe {

/// What one pass over the source points gives: Gauss-Newton's normal equations for a left increment about a centre,
/// and the figures of the fit. Rotation first.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double inliers = 0;
  double squared_plane_m2 = 0;
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();  // sum of the partners' N
  Eigen::Matrix3d levers = Eigen::Matrix3d::Zero();   // sum of q q^T; q: from the centre
  NormalEquations& operator+=(const NormalEquations& o);
};

/// What a pair of points is taken to say.
struct FactorModel {
  /// Variance along the normal over the variance along the plane: how rough the rock is against how far apart the
  /// points are, squared. Larger values tell less of planes and hold a slide back.
  double plane_epsilon = 1e-3;
  /// A plane distance of this part of the reach quarters a pair's weight: far partners guide, near ones decide.
  double kernel_share = 0.2;
};

/// A symmetric 3x3 matrix as xx, xy, xz, yy, yz, zz.
using Symmetric3f = std::array<float, 6>;
Symmetric3f outer(const Eigen::Vector3f& n);

/// Pairs of a source point and its partner, kept by component so that four are worked on at once. Shapes are planes:
/// N is the outer product of the normal, or the mean of such products over a voxel; a covariance is I - (1 - eps) N.
/// All in the target frame; source points relative to a centre.
class FactorBlock {
 public:
  static constexpr std::size_t capacity = 256;
  void clear() { count_ = 0; }
  std::size_t size() const { return count_; }

  /// At most `capacity` between two clears. q: the moved source point less the centre; e: the moved source point less
  /// its partner; n_s: the source's unit normal.
  void add(const Eigen::Vector3f& q, const Eigen::Vector3f& e, const Symmetric3f& N_t, const Eigen::Vector3f& n_s) {
    for (std::size_t a = 0; a < 3; ++a) {
      q_[a][count_] = q[static_cast<Eigen::Index>(a)];
      e_[a][count_] = e[static_cast<Eigen::Index>(a)];
      n_s_[a][count_] = n_s[static_cast<Eigen::Index>(a)];
    }
    for (std::size_t k = 0; k < 6; ++k) N_t_[k][count_] = N_t[k];
    ++count_;
  }

  /// The sum of e^T (C_t + C_s)^-1 e under a Geman-McClure weight, without the pairs whose normals differ by over 60
  /// deg.
  NormalEquations sum(const FactorModel& model, double reach_m);

  /// Appends the distances of the pairs from their partners' planes, m, leaving out the same pairs.
  void append_distances(std::vector<float>& distances_m) const;

 private:
  using Row = std::array<float, capacity>;
  alignas(32) std::array<Row, 3> q_, e_, n_s_;
  alignas(32) std::array<Row, 6> N_t_;
  std::size_t count_ = 0;
};

/// The factors of `count` source points, which `add` puts into a block for those from begin to end, summed up. Their
/// distances are appended to distances_m unless it is null. The result does not depend on the number of threads.
NormalEquations sum_factors(std::size_t count, int threads, const FactorModel& model, double reach_m,
                            const std::function<void(std::size_t begin, std::size_t end, FactorBlock&)>& add,
                            std::vector<float>* distances_m);

}  // namespace headframe
