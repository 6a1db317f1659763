#include "server/registration/verification.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

using Clouds = std::vector<PlacedCloud>;

Eigen::Vector3d place_of(const PlacedCloud& c) { return c.T_local_sensor.translation(); }

double distance_to_m(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& p) {
  double nearest = std::numeric_limits<double>::max();
  for (const PlacedCloud& c : clouds) nearest = std::min(nearest, (place_of(c) - p).squaredNorm());
  return std::sqrt(nearest);
}

/// Clouds of b that lie within reach of one of a's.
Clouds near_other(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_a_b, double reach_m) {
  Clouds out;
  for (const PlacedCloud& c : b)
    if (distance_to_m(a, T_a_b * place_of(c)) < reach_m) out.push_back(c);
  return out;
}

bool usable(const Registration& r) { return r.status != RegistrationStatus::too_little_overlap; }

/// Places as far from each other as can be, beginning with the first one.
std::vector<Eigen::Vector3d> spread(const Eigen::Vector3d& first, const Clouds& candidates, std::size_t most) {
  std::vector<Eigen::Vector3d> chosen{first};
  while (chosen.size() < most) {
    double farthest = 4;  // nearer than this it is the same place
    const PlacedCloud* next = nullptr;
    for (const PlacedCloud& c : candidates) {
      double nearest = std::numeric_limits<double>::max();
      for (const auto& p : chosen) nearest = std::min(nearest, (place_of(c) - p).norm());
      if (nearest <= farthest) continue;
      farthest = nearest;
      next = &c;
    }
    if (!next) break;
    chosen.push_back(place_of(*next));
  }
  return chosen;
}

Eigen::Matrix3d hold_matrix(const Registration& r) { return r.information.bottomRightCorner<3, 3>(); }

/// One T for all places: each pulls its p_b to where its own registration put it, as firmly as its points hold each
/// direction, and its rotation as a body of 8 m would.
Pose combine(const std::vector<PlaceCheck>& places, const std::vector<bool>& agrees, const Pose& T_0) {
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

double share(double part, double whole) { return whole > 0 ? part / whole : 0; }

void gather(Evidence& e, const std::vector<PlaceCheck>& places, const std::vector<bool>& agrees, const Pose& T) {
  Visibility between, own;
  Eigen::Matrix3d hold = Eigen::Matrix3d::Zero();
  std::vector<double> residuals;
  double squared = 0, inliers = 0, slide = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlaceCheck& p = places[i];
    between += p.between;
    e.worst_place_violation = std::max(e.worst_place_violation, p.between.violation());
    own += p.own;
    inliers += p.registration.inlier_fraction;
    if (!agrees[i]) continue;
    e.places_agreeing += 1;
    residuals.push_back(p.residual_m);
    hold += hold_matrix(p.registration);
    slide += p.slide_ratio;
    squared += (T * p.p_b - p.p_a).squaredNorm();
    e.rmse_m += p.registration.rmse_m;
  }
  e.places = static_cast<double>(places.size());
  e.inlier_fraction = inliers / e.places;
  e.rmse_m /= e.places_agreeing;
  e.slide_ratio = slide / e.places_agreeing;
  e.spread_m = std::sqrt(squared / e.places_agreeing);
  std::sort(residuals.begin(), residuals.end());
  e.residual_m = residuals[residuals.size() / 2];
  e.weakest_hold = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(hold / hold.trace()).eigenvalues()[0];
  e.seen_points = between.seen;
  e.freespace_violation = share(between.violated, between.seen + between.violated);
  e.own_violation = share(own.violated, own.seen + own.violated);
  e.overlap_a = e.overlap_b = share(between.seen, between.seen + between.violated + between.lone + between.unknown);
  e.tilt_deg = tilt_rad(T) * 180 / std::numbers::pi;
}

/// Everything both sessions have where they meet, registered at once from T_0: pulls out a slide along a drift that
/// each place by itself allows. T_0 when that does not converge nearby.
Pose align_overlap(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Clouds& shared_b,
                   const Pose& T_0, const JudgeConfig& config) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PlacedCloud& c : shared_b) centre += place_of(c) / static_cast<double>(shared_b.size());
  double reach = 0;
  for (const PlacedCloud& c : shared_b) reach = std::max(reach, (place_of(c) - centre).norm());
  reach += config.place.radius_m;
  const Submap target = sphere(a, T_0 * centre, reach + config.place.slack_m, config.overlap_leaf_m);
  const Submap source = sphere(b, centre, reach, config.overlap_leaf_m);
  VgicpConfig vgicp;
  vgicp.levels = {{1.0F, 4000}, {0.5F, 12000}};
  vgicp.iterations = 25;
  vgicp.least_inliers = 0.05;
  vgicp.threads = config.threads;
  const Registration r =
      align(make_voxel_maps(target.points, target.normals, vgicp), source.points, source.normals, T_0, vgicp);
  const bool near = (r.T_target_source * centre - T_0 * centre).norm() < config.place_drift_m &&
                    rotation_angle_rad(T_0.inverse() * r.T_target_source) < config.place_drift_rad;
  return usable(r) && near ? r.T_target_source : T_0;
}

/// Path of b, in metres, along which its keyframes lie within reach of a's.
double shared_path_m(const Clouds& near) {
  double path = 0;
  for (std::size_t i = 1; i < near.size(); ++i)
    if (near[i].sequence - near[i - 1].sequence <= 2) path += (place_of(near[i]) - place_of(near[i - 1])).norm();
  return path;
}

/// How far T_a_b may be off at p for the drift between there and the first place.
bool within_drift(const PlaceCheck& place, const PlaceCheck& first, const Pose& T, const JudgeConfig& config) {
  const double allowed_m = config.place_drift_m + config.place_drift_share * (place.p_b - first.p_b).norm();
  return usable(place.registration) && (T * place.p_b - place.p_a).norm() < allowed_m &&
         rotation_angle_rad(T.inverse() * place.registration.T_target_source) < config.place_drift_rad;
}

}  // namespace

Glance glance(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_0,
              const Eigen::Vector3d& p_b, const JudgeConfig& config) {
  Glance out;
  double nearest = std::numeric_limits<double>::max();
  const PlacedCloud* centre = nullptr;
  for (const PlacedCloud& c : b) {
    const double meet_m = std::max(0.0, distance_to_m(a, T_0 * place_of(c)) - config.meet_m / 2);
    const double d = (place_of(c) - p_b).norm() + 10 * meet_m;
    if (d >= nearest) continue;
    nearest = d;
    centre = &c;
  }
  if (!centre || distance_to_m(a, T_0 * place_of(*centre)) > 2 * config.meet_m) return out;
  out.place = register_place(a, b, place_of(*centre), T_0, config.place);
  const Registration& r = out.place.registration;
  const Pose moved = T_0.inverse() * r.T_target_source;
  if (!usable(r) || r.inlier_fraction < config.hopeless_inliers || tilt_rad(r.T_target_source) > 0.1 ||
      (moved * out.place.p_b - out.place.p_b).norm() > 8)
    return out;
  look_at_place(out.place, a, b, r.T_target_source, config.place);
  out.hopeful = out.place.between.violation() < config.hopeless_violation;
  return out;
}

Judgement judge(std::span<const PlacedCloud> all_a, std::span<const PlacedCloud> all_b, const Glance& first,
                const JudgeConfig& config) {
  Judgement out;
  out.evidence.freespace_violation = first.place.between.violation();
  out.evidence.inlier_fraction = first.place.registration.inlier_fraction;
  if (!first.hopeful) return out;
  const Pose& T_0 = first.place.registration.T_target_source;
  const Clouds b = near_other(all_a, all_b, T_0, config.look_m),
               a = near_other(all_b, all_a, T_0.inverse(), config.look_m);
  const auto chosen = spread(first.place.p_b, near_other(a, b, T_0, config.meet_m), config.places);
  std::vector<PlaceCheck> places(chosen.size());
  for_blocks(chosen.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    places[i] = i == 0 ? first.place : register_place(a, b, chosen[i], T_0, config.place);
  });
  std::vector<bool> agrees;
  agrees.reserve(places.size());
  for (const PlaceCheck& p : places) agrees.push_back(within_drift(p, places[0], T_0, config));
  out.T_a_b = combine(places, agrees, T_0);
  if (const Clouds shared = near_other(a, b, out.T_a_b, config.meet_m); !shared.empty())
    out.T_a_b = align_overlap(a, b, shared, out.T_a_b, config);
  // Each place is looked at where its own registration put it: drift is not a contradiction, other rock is.
  for_blocks(places.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    if (i > 0)
      look_at_place(places[i], a, b, agrees[i] ? places[i].registration.T_target_source : out.T_a_b, config.place);
  });
  gather(out.evidence, places, agrees, out.T_a_b);
  const Clouds shared = near_other(a, b, out.T_a_b, config.meet_m);
  out.evidence.pairs = static_cast<double>(shared.size());
  out.evidence.overlap_m = shared_path_m(shared);
  out.status = first.place.registration.status;
  if (out.evidence.weakest_hold >= VgicpConfig{}.degenerate_below) out.status = RegistrationStatus::converged;
  out.evidence.probability = probability(out.status, out.evidence);
  return out;
}

bool fits_alone(const Glance& glance) {
  const Registration& r = glance.place.registration;
  return glance.hopeful && r.status == RegistrationStatus::converged && r.direction_hold[0] > 0.05 &&
         r.inlier_fraction > 0.7 && glance.place.residual_m < 0.045 && glance.place.between.violation() < 0.004;
}

Judgement judge_again(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_0,
                      const JudgeConfig& config) {
  const Clouds near = near_other(a, b, T_0, config.meet_m);
  if (near.empty()) return {};
  return judge(a, b, glance(a, b, T_0, place_of(near[near.size() / 2]), config), config);
}

double probability(RegistrationStatus status, const Evidence& e) {
  if (status == RegistrationStatus::too_little_overlap) return 0;
  if (e.tilt_deg > 3) return 0;
  // Set by hand; README, "How sure", says on which pairs, and on which they were checked.
  const double contradiction = std::log10(e.worst_place_violation + 2e-3) + 2.7;  // 0: none
  const double misfit = std::max(-0.1, std::log10(e.residual_m + 0.01) + 1.4);    // 0: 3 cm
  const double few_pairs = std::min(0.0, std::log10((e.pairs + 1) / 4));
  // Where the mine repeats itself, exact copies pass every local test: only a longer overlap tells them apart.
  // It costs at most 0.27 an alias: with one, an overlap of half the length still passes when all else is good.
  const double asked_m = asked_overlap_m(e);
  const double short_overlap = asked_m > 0 ? std::max(-0.27 * e.aliases, std::min(0.0, e.overlap_m / asked_m - 1)) : 0;
  const double tiny_overlap = std::min(0.0, e.overlap_m / 8 - 1);
  const double z = 6 - 6 * contradiction - 12 * misfit - 12 * (1 - e.places_agreeing / std::max(1.0, e.places)) +
                   4 * few_pairs + 12 * short_overlap + 6 * tiny_overlap;
  const double p = 1 / (1 + std::exp(-z));
  // What slides freely along the drift can look right at many places: at most a candidate.
  return status == RegistrationStatus::converged ? p : 0.4 * p;
}

}  // namespace headframe
