#pragma once

#include <span>

#include "server/verification/prepared_cloud.hpp"

namespace headframe {

/// What the sweeps of one session say of a point of the other session's rock.
enum class PointSight : std::uint8_t {
  unknown,   // hidden, out of range, outside the field of view
  seen,      // it lies on a surface that the sweeps hit
  violated,  // the sweeps' rays passed through it
  lone,      // the same, but without violated points nearby
};

/// How the points of one session look from the sweeps of another. A violated point counts only if three more lie near
/// it: a single one is dust or an edge, whereas missing rock makes patches.
struct Visibility {
  double seen = 0;      // points on a surface that the sweeps hit
  double violated = 0;  // points that the sweeps' rays passed through
  double lone = 0;      // violated points that stand alone
  double unknown = 0;   // neither: hidden, out of range, outside the field of view
  Visibility& operator+=(const Visibility& other);
  double all() const { return seen + violated + lone + unknown; }
  /// The points that could be compared, and 100 more that agree, because few points prove little: at one place of a
  /// right placement two of 46 were violated, which held back five merges.
  double compared() const { return seen + violated + 100; }
  double violation() const { return violated / compared(); }
};

/// One sweep of a session and the pose from which it was taken.
struct PlacedView {
  Pose T_local_view = Pose::Identity();
  std::shared_ptr<const SightImage> image;
};

/// The sweeps of these clouds that were taken within reach_m of the centre, the nearest first.
std::vector<PlacedView> views_near(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double reach_m);

/// The surfels without those that the session's own sweeps see through as often as they hit them: dust, people,
/// vehicles that drove on. All in the session's local frame.
SurfelCloud without_transients(const SurfelCloud& surfels, std::span<const PlacedView> own, float reach_m);

/// What a's sweeps say of b's surfels (in b's local frame, one per leaf_m), up to a range of reach_m; one answer for
/// each surfel, decided by the first eight sweeps that know anything of it. A ray that passes through a surface at a
/// grazing angle does not count. slack_m: of SightImage::look().
std::vector<PointSight> sights_from(std::span<const PlacedView> a, const SurfelCloud& b, const Pose& T_a_b,
                                    float reach_m, float leaf_m, float slack_m = 0);

Visibility summed_up(std::span<const PointSight> sights);

/// The same, as sums.
inline Visibility look_from(std::span<const PlacedView> a, const SurfelCloud& b, const Pose& T_a_b, float reach_m,
                            float leaf_m) {
  return summed_up(sights_from(a, b, T_a_b, reach_m, leaf_m));
}

}  // namespace headframe
