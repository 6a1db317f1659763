#pragma once

#include <span>

#include "server/verification/prepared_cloud.hpp"

namespace headframe {

/// What the sweeps of one session say of a point of the other's rock.
enum class PointSight : std::uint8_t {
  unknown,   // hidden, out of range, outside the field of view
  seen,      // it lies on a surface that they met
  violated,  // their rays went through it
  lone,      // the same, and it stands alone
};

/// How the points of one session look from the sweeps of another. A lone point that rays pass through is dust or the
/// edge of something; rock that is not there makes patches. So a violation counts when three more lie near it.
struct Visibility {
  double seen = 0;      // points that lie on a surface the sweeps met
  double violated = 0;  // points that the sweeps' rays went through
  double lone = 0;      // violations that stand alone
  double unknown = 0;   // neither: hidden, out of range, outside the field of view
  Visibility& operator+=(const Visibility& other);
  double all() const { return seen + violated + lone + unknown; }
  double violation() const { return seen + violated > 0 ? violated / (seen + violated) : 0; }
};

/// One sweep of a session, where it stood.
struct PlacedView {
  Pose T_local_view = Pose::Identity();
  std::shared_ptr<const SightImage> image;
};

/// The sweeps of these clouds within reach of the centre, the nearest first.
std::vector<PlacedView> views_near(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double reach_m);

/// Surfels of a session without what its own sweeps see through as often as they meet it: dust, people, vehicles that
/// drove on. All in the session's local frame.
SurfelCloud without_transients(const SurfelCloud& surfels, std::span<const PlacedView> own, float reach_m);

/// Surfels in b's local frame, one per leaf_m, viewed from a's sweeps, up to reach_m: one answer for each. The first
/// eight sweeps that know something of a point decide on it. A ray that would only graze the surface says nothing when
/// it goes on behind it.
std::vector<PointSight> sights_from(std::span<const PlacedView> a, const SurfelCloud& b, const Pose& T_a_b,
                                    float reach_m, float leaf_m);

Visibility summed_up(std::span<const PointSight> sights);

/// The same, summed up.
inline Visibility look_from(std::span<const PlacedView> a, const SurfelCloud& b, const Pose& T_a_b, float reach_m,
                            float leaf_m) {
  return summed_up(sights_from(a, b, T_a_b, reach_m, leaf_m));
}

}  // namespace headframe
