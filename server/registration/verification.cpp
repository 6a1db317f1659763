#include "server/registration/verification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/registration/visibility.hpp"

namespace headframe {
namespace {

using Clouds = std::vector<PlacedCloud>;

Eigen::Vector3d place(const PlacedCloud& c) { return c.T_local_sensor.translation(); }

/// Clouds of each session that lie within reach of one of the other's.
struct Meeting {
  Clouds a, b;
  Meeting(std::span<const PlacedCloud> all_a, std::span<const PlacedCloud> all_b, const Pose& T_a_b, double reach_m) {
    const auto near = [&](const Eigen::Vector3d& p_a, const PlacedCloud& c_b) {
      return (p_a - T_a_b * place(c_b)).squaredNorm() < reach_m * reach_m;
    };
    for (const auto& x : all_a)
      if (std::any_of(all_b.begin(), all_b.end(), [&](const auto& y) { return near(place(x), y); })) a.push_back(x);
    for (const auto& y : all_b)
      if (std::any_of(all_a.begin(), all_a.end(), [&](const auto& x) { return near(place(x), y); })) b.push_back(y);
  }
  bool empty() const { return a.empty() || b.empty(); }
};

/// Distance to the keyframe before, or to the one after for the first: FRAME's local spacing l.
double spacing_m(std::span<const PlacedCloud> clouds, std::size_t i) {
  if (clouds.size() < 2) return 10;
  const std::size_t j = i > 0 ? i - 1 : 1;
  return (place(clouds[i]) - place(clouds[j])).norm();
}

/// GICP of the two spheres around the keyframes that the hypothesis brings nearest to each other (FRAME, step 8).
Registration align_spheres(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_0,
                           const JudgeConfig& config) {
  double nearest = std::numeric_limits<double>::max();
  std::size_t centre = 0;
  for (std::size_t j = 0; j < b.size(); ++j)
    for (const auto& x : a) {
      const double d = (place(x) - T_0 * place(b[j])).squaredNorm();
      if (d < nearest) {
        nearest = d;
        centre = j;
      }
    }
  Registration nothing;
  if (std::sqrt(nearest) > config.meet_m) return nothing;
  // The paper's radius, but not below 15 m: a sphere of 5 m has too little to hold on to (the paper's own finding).
  const double radius = std::max(15.0, sphere_radius_m(spacing_m(b, centre)));
  const Eigen::Vector3d p_b = place(b[centre]);
  const Surfels target = make_surfels(sphere(a, T_0 * p_b, radius + 5, config.local_leaf_m), 20, config.threads);
  const Surfels source = make_surfels(sphere(b, p_b, radius, config.local_leaf_m), 20, config.threads);
  GicpConfig gicp;
  gicp.threads = config.threads;
  return align(target, source, T_0, gicp);
}

/// GICP of everything both sessions have where they meet: pulls out slides that one sphere allows.
Registration align_overlap(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_0,
                           const JudgeConfig& config) {
  const Meeting meeting(a, b, T_0, config.meet_m);
  if (meeting.empty()) return {};
  const Surfels target = make_surfels(merged(meeting.a, config.overlap_leaf_m), 20, config.threads);
  const Surfels source = make_surfels(merged(meeting.b, config.overlap_leaf_m), 20, config.threads);
  GicpConfig gicp;
  gicp.threads = config.threads;
  gicp.coarse_reach_m = 1.5;
  gicp.fine_reach_m = 0.6;
  gicp.stages = 3;
  gicp.iterations = 25;
  gicp.least_inliers = 0.05;
  return align(target, source, T_0, gicp);
}

double share(double part, double whole) { return whole > 0 ? part / whole : 0; }

double score(const Visibility& v) { return v.seen - 3 * v.violated; }

/// A session against itself: every other cloud's points, seen from the ones between.
Visibility own_visibility(const Clouds& clouds, const JudgeConfig& config) {
  Clouds even, odd;
  for (std::size_t i = 0; i < clouds.size(); ++i) (i % 2 == 0 ? even : odd).push_back(clouds[i]);
  return look_from(odd, merged(even, config.evidence_leaf_m), Pose::Identity(), config.view_reach_m, config.threads);
}

/// What both sessions say of each other, asked at places spread over the overlap, each registered once more by itself:
/// the drift between two places is not taken for a contradiction, but rock that differs is.
struct LocalEvidence {
  Visibility of_a, of_b;
  double places = 0, agreeing = 0;
};

LocalEvidence look_at_places(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_a_b,
                             const JudgeConfig& config) {
  const Meeting near(a, b, T_a_b, config.place_reach_m);
  const Clouds& centres = near.b;
  LocalEvidence out;
  const std::size_t count = std::min(centres.size(), config.places);
  for (std::size_t i = 0; i < count; ++i) {
    // Evenly from the first to the last, or the middle one alone.
    const std::size_t pick = count == 1 ? centres.size() / 2 : i * (centres.size() - 1) / (count - 1);
    const Eigen::Vector3d p_b = place(centres[pick]), p_a = T_a_b * p_b;
    const Points points_a = sphere(a, p_a, config.place_radius_m, config.evidence_leaf_m);
    const Points points_b = sphere(b, p_b, config.place_radius_m, config.evidence_leaf_m);
    GicpConfig gicp;
    gicp.coarse_reach_m = 1.5;
    gicp.fine_reach_m = 0.6;
    gicp.stages = 2;
    gicp.threads = config.threads;
    const Registration r =
        align(make_surfels(points_a, 12, config.threads), make_surfels(points_b, 12, config.threads), T_a_b, gicp);
    const Pose moved = T_a_b.inverse() * r.T_target_source;
    const bool agrees = (r.status == RegistrationStatus::converged || r.status == RegistrationStatus::degenerate) &&
                        (moved * p_b - p_b).norm() < config.place_drift_m &&
                        rotation_angle_rad(moved) < config.place_drift_rad;
    out.places += 1;
    out.agreeing += agrees;
    const Pose T = agrees ? r.T_target_source : T_a_b;
    const auto views = [&](std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre) {
      Clouds within;
      for (const auto& c : clouds)
        if ((place(c) - centre).norm() < config.view_reach_m) within.push_back(c);
      return within;
    };
    out.of_b += look_from(views(a, p_a), points_b, T, config.view_reach_m, config.threads);
    out.of_a += look_from(views(b, p_b), points_a, T.inverse(), config.view_reach_m, config.threads);
  }
  return out;
}

void gather(Judgement& out, const Registration& r, std::span<const PlacedCloud> all_a,
            std::span<const PlacedCloud> all_b, const JudgeConfig& config) {
  Evidence& e = out.evidence;
  e.inlier_fraction = r.inlier_fraction;
  e.rmse_m = r.rmse_m;
  e.weakest_hold = r.direction_hold[0];
  e.tilt_deg = tilt_rad(r.T_target_source) * 180 / std::numbers::pi;
  e.freespace_violation = 1;  // until it is looked at
  if (e.inlier_fraction < config.hopeless_inliers) return;
  const Meeting meeting(all_a, all_b, r.T_target_source, config.look_m);
  const Points points_a = merged(meeting.a, config.evidence_leaf_m),
               points_b = merged(meeting.b, config.evidence_leaf_m);
  const auto look = [&](const Pose& T_a_b) {
    return std::pair(look_from(meeting.a, points_b, T_a_b, config.view_reach_m, config.threads),
                     look_from(meeting.b, points_a, T_a_b.inverse(), config.view_reach_m, config.threads));
  };
  const auto [of_b, of_a] = look(r.T_target_source);
  e.seen_points = of_a.seen + of_b.seen;
  e.overlap_a = share(of_a.seen, static_cast<double>(points_a.size()));
  e.overlap_b = share(of_b.seen, static_cast<double>(points_b.size()));
  e.freespace_violation = share(of_a.violated + of_b.violated, e.seen_points + of_a.violated + of_b.violated);
  for (const auto& y : meeting.b)
    e.pairs += std::any_of(meeting.a.begin(), meeting.a.end(),
                           [&](const auto& x) { return (place(x) - r.T_target_source * place(y)).norm() < 10; });
  if (e.freespace_violation > config.hopeless_violation) return;

  const LocalEvidence local = look_at_places(meeting.a, meeting.b, r.T_target_source, config);
  const double violated = local.of_a.violated + local.of_b.violated;
  if (local.places > 0) e.freespace_violation = share(violated, local.of_a.seen + local.of_b.seen + violated);
  e.places = local.places;
  e.places_agreeing = local.agreeing;
  const Visibility own_a = own_visibility(meeting.a, config), own_b = own_visibility(meeting.b, config);
  e.own_violation = share(own_a.violated + own_b.violated, own_a.seen + own_a.violated + own_b.seen + own_b.violated);
  e.slide_ratio = -1;
  const double here = score(of_a) + score(of_b);
  for (double slide_m : {-6.0, -3.0, 3.0, 6.0}) {
    if (here <= 0) break;
    const auto [slid_b, slid_a] = look(Eigen::Translation3d(slide_m * r.weakest_direction) * r.T_target_source);
    e.slide_ratio = std::max(e.slide_ratio, (score(slid_a) + score(slid_b)) / here);
  }
}

Judgement finish(const Registration& r, std::span<const PlacedCloud> a, std::span<const PlacedCloud> b,
                 const JudgeConfig& config) {
  Judgement out;
  out.status = r.status;
  out.T_a_b = r.T_target_source;
  if (r.status == RegistrationStatus::too_little_overlap) return out;
  gather(out, r, a, b, config);
  out.evidence.probability = probability(out.status, out.evidence);
  return out;
}

}  // namespace

Judgement judge(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_0,
                const JudgeConfig& config) {
  const Registration local = align_spheres(a, b, T_0, config);
  // Right placements had at least 0.86 of the sphere's points met, wrong ones often a fifth: those are not worth the
  // rest.
  if (local.inlier_fraction < 0.4 || tilt_rad(local.T_target_source) > 0.1) return {};
  return judge_again(a, b, local.T_target_source, config);
}

Judgement judge_again(std::span<const PlacedCloud> a, std::span<const PlacedCloud> b, const Pose& T_0,
                      const JudgeConfig& config) {
  return finish(align_overlap(a, b, T_0, config), a, b, config);
}

double probability(RegistrationStatus status, const Evidence& e) {
  if (status == RegistrationStatus::too_little_overlap || status == RegistrationStatus::not_converged) return 0;
  if (e.tilt_deg > 3) return 0;
  // How much more the sessions contradict each other than each does itself. README, "How sure", has the pairs that the
  // weights were fitted on: right placements had at most 0.0023 of violations, most wrong ones 0.003 to 0.12.
  constexpr double floor = 1e-3, free = 0.1;
  const double excess = std::max(0.0, std::log10((e.freespace_violation + floor) / (e.own_violation + floor)) - free);
  const double few_pairs = std::min(0.0, std::log10((e.pairs + 1) / 4));
  const double few_points = std::min(0.0, std::log10((e.seen_points + 1) / 6000));
  const double z = 4.5 - 10 * excess + 6 * (e.inlier_fraction - 0.6) + 1.5 * (std::log10(e.weakest_hold + 1e-3) + 1.5) +
                   3 * few_pairs + 2 * few_points;
  const double p = 1 / (1 + std::exp(-z));
  // What slides freely along the drift can look right at many places: at most a candidate.
  return status == RegistrationStatus::degenerate ? 0.4 * p : p;
}

}  // namespace headframe
