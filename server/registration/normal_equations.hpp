#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "server/registration/registration.hpp"

namespace headframe {

/// The result of one pass over the source points: the normal equations of Gauss-Newton for a left increment about a
/// centre, rotation first, and measures of the fit.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double inliers = 0;
  double squared_plane_m2 = 0;
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();  // sum of the partners' N
  Eigen::Matrix3d levers = Eigen::Matrix3d::Zero();   // sum of q q^T; q: relative to the centre
  NormalEquations& operator+=(const NormalEquations& o);
};

/// Model of the error of a pair of points.
struct FactorModel {
  /// Variance along the normal divided by the variance within the plane: the squared ratio of the rock's roughness to
  /// the distance between points. Larger values rely less on planes and resist sliding.
  double plane_epsilon = 1e-3;
  /// A plane distance of this share of the reach quarters a pair's weight: far partners guide, near ones decide.
  double kernel_share = 0.2;
};

/// A symmetric 3x3 matrix as xx, xy, xz, yy, yz, zz.
using Symmetric3f = std::array<float, 6>;
Symmetric3f outer(const Eigen::Vector3f& n);

/// Pairs of a source point and its partner, stored by component so that four can be processed at once. Surfaces are
/// planes: N is the outer product of the normal, or the mean of such products over a voxel, and the covariance is I -
/// (1 - eps) N. All in the target frame; source points relative to a centre.
class FactorBlock {
 public:
  static constexpr std::size_t capacity = 256;
  void clear() { count_ = 0; }
  std::size_t size() const { return count_; }

  /// Add at most `capacity` pairs between two calls of clear(). q: the transformed source point minus the centre; e:
  /// the transformed source point minus its partner; n_s: the source's unit normal.
  void add(const Eigen::Vector3f& q, const Eigen::Vector3f& e, const Symmetric3f& N_t, const Eigen::Vector3f& n_s) {
    for (std::size_t a = 0; a < 3; ++a) {
      q_[a][count_] = q[static_cast<Eigen::Index>(a)];
      e_[a][count_] = e[static_cast<Eigen::Index>(a)];
      n_s_[a][count_] = n_s[static_cast<Eigen::Index>(a)];
    }
    for (std::size_t k = 0; k < 6; ++k) N_t_[k][count_] = N_t[k];
    ++count_;
  }

  /// The sum of e^T (C_t + C_s)^-1 e with Geman-McClure weights; pairs whose normals differ by more than 60 deg are
  /// ignored.
  NormalEquations sum(const FactorModel& model, double reach_m);

  /// Appends the pairs' distances from their partners' planes, in m, ignoring the same pairs.
  void append_distances(std::vector<float>& distances_m) const;

 private:
  using Row = std::array<float, capacity>;
  alignas(32) std::array<Row, 3> q_, e_, n_s_;
  alignas(32) std::array<Row, 6> N_t_;
  std::size_t count_ = 0;
};

/// The sum over `count` source points; `add` puts the pairs of points begin to end into a block. Distances are appended
/// to distances_m unless it is null. The result does not depend on the number of threads.
NormalEquations sum_factors(std::size_t count, int threads, const FactorModel& model, double reach_m,
                            const std::function<void(std::size_t begin, std::size_t end, FactorBlock&)>& add,
                            std::vector<float>* distances_m);

}  // namespace headframe
