#include "server/registration/verification.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/registration/end_on.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

using Stands = std::vector<Stand>;

struct Nearest {
  const Stand* stand = nullptr;
  double distance_m = std::numeric_limits<double>::max();
};

Nearest nearest_to(std::span<const Stand> stands, const Eigen::Vector3d& p) {
  Nearest out;
  for (const Stand& s : stands)
    if (const double d = (s.p - p).norm(); d < out.distance_m) out = {&s, d};
  return out;
}

/// Stands of b that come within reach of one of a's.
Stands near_other(std::span<const Stand> a, std::span<const Stand> b, const Pose& T_a_b, double reach_m) {
  Stands out;
  for (const Stand& s : b)
    if (nearest_to(a, T_a_b * s.p).distance_m < reach_m) out.push_back(s);
  return out;
}

bool usable(const Registration& r) { return r.status != RegistrationStatus::too_little_overlap; }

/// Stands as far from each other as can be, none nearer than 4 m to the first place, which is taken already.
Stands spread(const Eigen::Vector3d& first, const Stands& candidates, std::size_t most) {
  constexpr double same_place_m = 4;
  std::vector<Eigen::Vector3d> taken{first};
  Stands chosen;
  while (chosen.size() < most) {
    double farthest = same_place_m;
    const Stand* next = nullptr;
    for (const Stand& s : candidates) {
      double nearest = std::numeric_limits<double>::max();
      for (const auto& p : taken) nearest = std::min(nearest, (s.p - p).norm());
      if (nearest <= farthest) continue;
      farthest = nearest;
      next = &s;
    }
    if (!next) break;
    taken.push_back(next->p);
    chosen.push_back(*next);
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
  Visibility a_by_b, b_by_a, own;
  std::vector<double> residuals;
  double squared = 0, inliers = 0, slide = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PlaceCheck& p = places[i];
    a_by_b += p.a_by_b;
    b_by_a += p.b_by_a;
    e.worst_place_violation = std::max(e.worst_place_violation, p.between().violation());
    own += p.own;
    inliers += p.registration.inlier_fraction;
    if (!agrees[i]) continue;
    e.places_agreeing += 1;
    residuals.push_back(p.residual_m);
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
  Visibility between = a_by_b;
  between += b_by_a;
  e.seen_points = between.seen;
  e.freespace_violation = between.violation();
  e.own_violation = own.violation();
  e.overlap_a = share(a_by_b.seen, a_by_b.all());
  e.overlap_b = share(b_by_a.seen, b_by_a.all());
  e.tilt_deg = tilt_rad(T) * 180 / std::numbers::pi;
}

/// A place of the overlap as each session knows it.
struct Pair {
  PlacePtr a, b;
};

/// The agreeing places as one map.
struct Overlap {
  std::vector<VgicpPair> joined;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    // in b's frame
  Eigen::Vector3d weakest = Eigen::Vector3d::UnitX();  // direction in a's frame that holds least
  double weakest_hold = 0;
};

Overlap overlap_of(const std::vector<Pair>& pairs, const std::vector<PlaceCheck>& places,
                   const std::vector<bool>& agrees) {
  Overlap out;
  Eigen::Matrix3d hold = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!agrees[i]) continue;
    out.joined.push_back({&pairs[i].a->target, &pairs[i].b->source.points, &pairs[i].b->source.normals});
    out.centre += pairs[i].b->p;
    hold += hold_matrix(places[i].registration);
  }
  out.centre /= static_cast<double>(out.joined.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> held(hold / hold.trace());
  out.weakest = held.eigenvectors().col(0);
  out.weakest_hold = held.eigenvalues()[0];
  return out;
}

/// All registered at once from T_0: pulls out a slide along a drift that each by itself allows. T_0 when that does not
/// converge nearby.
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

/// Where a drift hardly holds the overlap along its axis, ribs that repeat catch a registration at any period: it is
/// slid to where the surfaces that face along the axis meet, and registered again there.
Pose settled(const Overlap& overlap, const Pose& T_a_b, const JudgeConfig& config, double& end_on_match) {
  const EndOnSurfaces here(overlap.joined, T_a_b, overlap.weakest);
  end_on_match = here.match(0);
  if (overlap.weakest_hold >= config.held_well || overlap.weakest_hold < config.held_by_nothing) return T_a_b;
  const double slide_m = here.best_slide_m(config.slide_m);
  if (slide_m == 0 || here.match(slide_m) < config.ends_meet) return T_a_b;
  const Pose T = align_overlap(overlap, Eigen::Translation3d(slide_m * overlap.weakest) * T_a_b, config);
  const double there = EndOnSurfaces(overlap.joined, T, overlap.weakest).match(0);
  if (there <= end_on_match) return T_a_b;
  end_on_match = there;
  return T;
}

/// Path of b, in metres, along which its keyframes lie within reach of a's.
double shared_path_m(const Stands& near) {
  double path = 0;
  for (std::size_t i = 1; i < near.size(); ++i)
    if (near[i].keyframe - near[i - 1].keyframe <= 2) path += (near[i].p - near[i - 1].p).norm();
  return path;
}

/// The first place's pair stands for itself: it is in `first` already.
std::vector<Pair> other_places(const Scene& a, const Scene& b, const Glance& first, const JudgeConfig& config) {
  const Pose& T = first.place.registration.T_target_source;
  const Stands chosen = spread(first.place.p_b, near_other(a.stands, b.stands, T, config.meet_m), config.places - 1);
  std::vector<std::size_t> of_a, of_b;
  for (const Stand& s : chosen) {
    of_a.push_back(nearest_to(a.stands, T * s.p).stand->keyframe);
    of_b.push_back(s.keyframe);
  }
  const auto places_a = a.places(of_a), places_b = b.places(of_b);
  std::vector<Pair> pairs;
  pairs.reserve(chosen.size() + 1);
  pairs.push_back({first.a, first.b});
  for (std::size_t i = 0; i < chosen.size(); ++i) pairs.push_back({places_a[i], places_b[i]});
  return pairs;
}

/// How far T_a_b may be off at p for the drift between there and the first place.
bool within_drift(const PlaceCheck& place, const PlaceCheck& first, const Pose& T, const JudgeConfig& config) {
  const double allowed_m = config.place_drift_m + config.place_drift_share * (place.p_b - first.p_b).norm();
  return usable(place.registration) && (T * place.p_b - place.p_a).norm() < allowed_m &&
         rotation_angle_rad(T.inverse() * place.registration.T_target_source) < config.place_drift_rad;
}

}  // namespace

std::optional<Meeting> first_meeting(std::span<const Stand> a, std::span<const Stand> b, const Pose& T_0,
                                     const Eigen::Vector3d& p_b, const JudgeConfig& config) {
  std::optional<Meeting> out;
  double least = std::numeric_limits<double>::max();
  for (const Stand& s : b) {
    const Nearest other = nearest_to(a, T_0 * s.p);
    const double cost = (s.p - p_b).norm() + 10 * std::max(0.0, other.distance_m - config.meet_m / 2);
    if (cost >= least || other.distance_m > 2 * config.meet_m) continue;
    least = cost;
    out = {other.stand->keyframe, s.keyframe};
  }
  return out;
}

Glance glance(const PlacePtr& a, const PlacePtr& b, const Pose& T_0, const JudgeConfig& config) {
  Glance out{false, register_place(*a, *b, T_0, config.place), a, b};
  const Registration& r = out.place.registration;
  const Pose moved = T_0.inverse() * r.T_target_source;
  if (!usable(r) || r.inlier_fraction < config.hopeless_inliers || tilt_rad(r.T_target_source) > 0.1 ||
      (moved * out.place.p_b - out.place.p_b).norm() > 8)
    return out;
  look_at_place(out.place, *a, *b, r.T_target_source, config.place);
  out.hopeful = out.place.between().violation() < config.hopeless_violation;
  return out;
}

Judgement judge(const Scene& a, const Scene& b, const Glance& first, const JudgeConfig& config) {
  Judgement out;
  out.evidence.freespace_violation = first.place.between().violation();
  out.evidence.inlier_fraction = first.place.registration.inlier_fraction;
  if (!first.hopeful) return out;
  const Pose& T_0 = first.place.registration.T_target_source;
  const std::vector<Pair> pairs = other_places(a, b, first, config);
  std::vector<PlaceCheck> places(pairs.size());
  for_blocks(pairs.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    places[i] = i == 0 ? first.place : register_place(*pairs[i].a, *pairs[i].b, T_0, config.place);
  });
  std::vector<bool> agrees;
  agrees.reserve(places.size());
  for (const PlaceCheck& p : places) agrees.push_back(within_drift(p, places[0], T_0, config));
  const Overlap overlap = overlap_of(pairs, places, agrees);
  out.T_a_b =
      settled(overlap, align_overlap(overlap, combine(places, agrees, T_0), config), config, out.evidence.end_on_match);
  out.evidence.weakest_hold = overlap.weakest_hold;
  // Each place is looked at where its own registration put it: drift is not a contradiction, other rock is.
  for_blocks(places.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
    if (i > 0)
      look_at_place(places[i], *pairs[i].a, *pairs[i].b, agrees[i] ? places[i].registration.T_target_source : out.T_a_b,
                    config.place);
  });
  gather(out.evidence, places, agrees, out.T_a_b);
  const Stands shared = near_other(a.stands, b.stands, out.T_a_b, config.meet_m);
  out.evidence.pairs = static_cast<double>(shared.size());
  out.evidence.overlap_m = shared_path_m(shared);
  out.status = first.place.registration.status;
  if (overlap.weakest_hold < config.held_by_nothing)
    out.status = RegistrationStatus::degenerate;
  else if (overlap.weakest_hold >= VgicpConfig{}.degenerate_below || out.evidence.end_on_match >= config.ends_meet)
    out.status = RegistrationStatus::converged;
  out.evidence.probability = probability(out.status, out.evidence);
  return out;
}

bool fits_alone(const Glance& glance) {
  const Registration& r = glance.place.registration;
  return glance.hopeful && r.status == RegistrationStatus::converged && r.direction_hold[0] > 0.05 &&
         r.inlier_fraction > 0.7 && glance.place.residual_m < 0.045 && glance.place.between().violation() < 0.004;
}

Judgement judge_again(const Scene& a, const Scene& b, const Pose& T_0, const JudgeConfig& config) {
  const Stands near = near_other(a.stands, b.stands, T_0, config.meet_m);
  if (near.empty()) return {};
  const auto meeting = first_meeting(a.stands, b.stands, T_0, near[near.size() / 2].p, config);
  const std::size_t at_a = meeting->keyframe_a, at_b = meeting->keyframe_b;
  return judge(a, b, glance(a.places({&at_a, 1}).front(), b.places({&at_b, 1}).front(), T_0, config), config);
}

double best_probability(const Glance& glance) {
  Evidence e;
  e.worst_place_violation = glance.place.between().violation();
  e.places = e.places_agreeing = e.inlier_fraction = e.weakest_hold = e.end_on_match = 1;
  e.pairs = e.overlap_m = std::numeric_limits<double>::max();
  return probability(RegistrationStatus::converged, e);
}

double probability(RegistrationStatus status, const Evidence& e) {
  if (status == RegistrationStatus::too_little_overlap) return 0;
  if (e.tilt_deg > 3) return 0;
  // Set by hand; README, "How sure", says on which pairs, and on which they were checked.
  const double contradiction = std::log10(e.worst_place_violation + 2e-3) + 2.7;  // 0: none
  const double misfit = std::max(-0.1, std::log10(e.residual_m + 0.01) + 1.4);    // 0: 3 cm
  // In drawn mines half of the right placements reach 0.91, and a tenth of the wrong ones 0.93.
  const double fit = std::clamp(8 * (e.inlier_fraction - 0.88), -1.2, 0.6);
  const double few_pairs = std::min(0.0, std::log10((e.pairs + 1) / 4));
  // Where the mine repeats itself, exact copies pass every local test: only a longer overlap tells them apart.
  // It costs at most 0.27 an alias: with one, an overlap of half the length still passes when all else is good.
  const double asked_m = asked_overlap_m(e);
  const double short_overlap = asked_m > 0 ? std::max(-0.27 * e.aliases, std::min(0.0, e.overlap_m / asked_m - 1)) : 0;
  const double tiny_overlap = std::min(0.0, e.overlap_m / 8 - 1);
  // In a drift that hardly holds the walls fit anywhere: what faces along it has to meet (in the recordings wrong
  // placements match 0.01 to 0.07, right ones 0.2 and more), and a contradiction counts twice.
  const bool hardly_held = e.weakest_hold < JudgeConfig{}.held_well;
  const double unmet = hardly_held ? std::min(0.0, e.end_on_match / JudgeConfig{}.ends_meet - 1) : 0;
  const double z = 6 + 6 * unmet - (hardly_held ? 12 : 6) * contradiction - 12 * misfit -
                   12 * (1 - e.places_agreeing / std::max(1.0, e.places)) + 4 * few_pairs + fit + 12 * short_overlap +
                   6 * tiny_overlap;
  const double p = 1 / (1 + std::exp(-z));
  // What slides freely along the drift can look right at many places: at most a candidate.
  return status == RegistrationStatus::converged ? p : 0.4 * p;
}

}  // namespace headframe
