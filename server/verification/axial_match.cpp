#include "server/verification/axial_match.hpp"

#include <algorithm>
#include <cmath>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

constexpr float least_facing = 0.5F;
constexpr float facing_share = 0.15F;  // of a voxel's normals: several surfaces meet in it
constexpr float near_m = 0.15F;
constexpr std::size_t fewest = 100;  // a handful of stray normals proves nothing

float along(const Symmetric3f& N, const Eigen::Vector3f& d) {
  const auto& [xx, xy, xz, yy, yz, zz] = N;
  return xx * d.x() * d.x() + yy * d.y() * d.y() + zz * d.z() * d.z() +
         2 * (xy * d.x() * d.y() + xz * d.x() * d.z() + yz * d.y() * d.z());
}

}  // namespace

AxialSurfaces::AxialSurfaces(std::span<const VgicpPair> pairs, const Pose& T_a_b, const Eigen::Vector3d& axis_a)
    : axis_(axis_a.cast<float>()) {
  const Eigen::Isometry3f T = T_a_b.cast<float>();
  for (const VgicpPair& pair : pairs) {
    Surfaces& here = surfaces_.emplace_back(Surfaces{&pair.target->back(), {}, {}});
    for (std::size_t i = 0; i < pair.source->size(); ++i) {
      const Eigen::Vector3f n = T.linear() * (*pair.normals)[i];
      if (std::abs(n.dot(axis_)) <= least_facing) continue;
      here.points.push_back(T * (*pair.source)[i]);
      here.normals.push_back(n);
    }
    count_ += here.points.size();
  }
}

double AxialSurfaces::match(double slide_m) const {
  const Eigen::Vector3f slide = static_cast<float>(slide_m) * axis_;
  double sum = 0;
  Points slid;
  std::vector<const Voxel*> partners;
  for (const Surfaces& here : surfaces_) {
    slid = here.points;
    for (auto& p : slid) p += slide;
    partners.resize(slid.size());
    here.target->nearest(slid, partners);
    for (std::size_t i = 0; i < slid.size(); ++i) {
      const Voxel* v = partners[i];
      if (!v) continue;
      const float trace = v->N[0] + v->N[3] + v->N[5];
      if (along(v->N, axis_) < facing_share * trace) continue;
      const float e = here.normals[i].dot(slid[i] - v->mean) / near_m;
      sum += static_cast<double>(std::exp(-e * e));
    }
  }
  return sum / static_cast<double>(std::max(fewest, count_));
}

double AxialSurfaces::best_slide_m(double reach_m, int threads) const {
  constexpr double step_m = 0.125, clearly = 0.05;
  const auto steps = static_cast<std::size_t>(reach_m / step_m);
  const auto slide_m = [&](std::size_t k) { return (static_cast<double>(k) - static_cast<double>(steps)) * step_m; };
  std::vector<double> matches(2 * steps + 1);
  for_blocks(matches.size(), 1, threads,
             [&](std::size_t k, std::size_t, std::size_t) { matches[k] = match(slide_m(k)); });
  const auto best = std::max_element(matches.begin(), matches.end());
  return *best > matches[steps] + clearly ? slide_m(static_cast<std::size_t>(best - matches.begin())) : 0;
}

}  // namespace headframe
