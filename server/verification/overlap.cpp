#include "server/verification/overlap.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "server/verification/axial_match.hpp"

namespace headframe {
namespace {

Eigen::Matrix3d hold_matrix(const Registration& r) { return r.information.bottomRightCorner<3, 3>(); }

}  // namespace

bool usable(const Registration& r) { return r.status != RegistrationStatus::too_little_overlap; }

Overlap overlap_of(const std::vector<SubmapPair>& pairs, const std::vector<SubmapCheck>& places,
                   const std::vector<bool>& agrees) {
  Overlap out;
  Eigen::Matrix3d hold = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const VgicpPair pair{&pairs[i].a->target, &pairs[i].b->source.points, &pairs[i].b->source.normals};
    if (usable(places[i].registration)) out.everywhere.push_back(pair);
    if (!agrees[i]) continue;
    out.joined.push_back(pair);
    out.centre += pairs[i].b->p;
    hold += hold_matrix(places[i].registration);
  }
  out.centre /= static_cast<double>(out.joined.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> held(hold / hold.trace());
  out.weakest = held.eigenvectors().col(0);
  out.weakest_hold = held.eigenvalues()[0];
  return out;
}

Pose combine(const std::vector<SubmapCheck>& places, const std::vector<bool>& agrees, const Pose& T_0) {
  Pose T = T_0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double count = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      if (agrees[i]) {
        centre += T * places[i].p_b;
        count += 1;
      }
    centre /= count;
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!agrees[i]) continue;
      Eigen::Matrix3d W = hold_matrix(places[i].registration);
      W /= W.trace();
      const Eigen::Vector3d p = T * places[i].p_b, e = p - places[i].p_a;
      Eigen::Matrix<double, 3, 6> J;
      J << -skew(p - centre), Eigen::Matrix3d::Identity();
      H += J.transpose() * W * J;
      g += J.transpose() * W * e;
      const double firmness = 64.0 / 3;
      const Eigen::AngleAxisd turn(T.linear() * places[i].registration.T_target_source.linear().transpose());
      H.topLeftCorner<3, 3>() += firmness * Eigen::Matrix3d::Identity();
      g.head<3>() += firmness * turn.angle() * turn.axis();
    }
    H.diagonal().array() += 1e-9;
    const Vector6d d = -H.ldlt().solve(g);
    if (!d.allFinite()) return T_0;
    T = Eigen::Translation3d(centre) * se3_exp(d) * Eigen::Translation3d(-centre) * T;
    if (d.norm() < 1e-7) break;
  }
  return orthonormalised(T);
}

Pose align_overlap(const Overlap& overlap, const Pose& T_0, const JudgeConfig& config) {
  VgicpConfig vgicp;
  vgicp.levels = {{1.0F, 4000}, {0.5F, 12000}};
  vgicp.iterations = 25;
  vgicp.least_inliers = 0.05;
  vgicp.threads = config.threads;
  const Eigen::Vector3d& centre = overlap.centre;
  const Registration r = align(overlap.joined, T_0, vgicp);
  const bool near = (r.T_target_source * centre - T_0 * centre).norm() < config.place_drift_m &&
                    rotation_angle_rad(T_0.inverse() * r.T_target_source) < config.place_drift_rad;
  return usable(r) && near ? r.T_target_source : T_0;
}

Pose settled(const Overlap& overlap, const Pose& T_a_b, const JudgeConfig& config, double& end_on_match) {
  const AxialSurfaces here(overlap.everywhere, T_a_b, overlap.weakest);
  end_on_match = here.match(0);
  if (overlap.weakest_hold >= held_well || overlap.weakest_hold < config.held_by_nothing) return T_a_b;
  const double slide_m = here.best_slide_m(config.slide_m, config.threads);
  if (slide_m == 0 || here.match(slide_m) < ends_meet) return T_a_b;
  Pose T = align_overlap(overlap, Eigen::Translation3d(slide_m * overlap.weakest) * T_a_b, config);
  const double there = AxialSurfaces(overlap.everywhere, T, overlap.weakest).match(0);
  if (there <= end_on_match) return T_a_b;
  end_on_match = there;
  return T;
}

}  // namespace headframe
