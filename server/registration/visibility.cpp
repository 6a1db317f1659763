#include "server/registration/visibility.hpp"

#include <algorithm>

#include "server/registration/kd_tree.hpp"

namespace headframe {
namespace {

constexpr std::size_t companions = 3;
constexpr float companion_leaves = 1.8F;
constexpr int views_asked = 8;

/// Whose violations have companions within reach is a patch.
void count_violations(const Points& violated, float reach_m, Visibility& total) {
  const KdTree tree(violated);
  std::vector<Neighbour> around;
  for (const auto& p : violated) {
    tree.nearest_k(p, companions + 1, around);  // itself among them
    const bool patch = around.size() > companions && around.back().squared_m < reach_m * reach_m;
    (patch ? total.violated : total.lone) += 1;
  }
}

}  // namespace

Visibility& Visibility::operator+=(const Visibility& other) {
  seen += other.seen;
  violated += other.violated;
  lone += other.lone;
  unknown += other.unknown;
  return *this;
}

std::vector<PlacedView> views_near(std::span<const PlacedCloud> clouds, const Eigen::Vector3d& centre, double reach_m) {
  std::vector<std::pair<double, PlacedView>> near;
  for (const PlacedCloud& c : clouds) {
    if ((c.T_local_sensor.translation() - centre).norm() > reach_m + 15) continue;
    for (const auto& view : c.cloud->views) {
      const Pose T = c.T_local_sensor * Eigen::Translation3d(view.origin.cast<double>());
      if (const double d = (T.translation() - centre).norm(); d < reach_m) near.push_back({d, {T, &view.image}});
    }
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  std::vector<PlacedView> views;
  views.reserve(near.size());
  for (const auto& [distance, view] : near) views.push_back(view);
  return views;
}

Visibility look_from(std::span<const PlacedView> a, const Points& points_b, const Pose& T_a_b, float reach_m,
                     float leaf_m) {
  struct View {
    Eigen::Isometry3f T_view_b;
    Eigen::Vector3f origin_b;
    const RangeImage* image;
  };
  std::vector<View> views;
  views.reserve(a.size());
  for (const PlacedView& view : a) {
    const Pose T_b_view = T_a_b.inverse() * view.T_local_view;
    views.push_back({T_b_view.inverse().cast<float>(), T_b_view.translation().cast<float>(), view.image});
  }
  Visibility total;
  Points violated;
  for (const auto& p : points_b) {
    int hits = 0, through = 0;
    for (const View& view : views) {
      if ((view.origin_b - p).squaredNorm() > reach_m * reach_m) continue;
      const Sight sight = view.image->look(view.T_view_b * p, reach_m);
      hits += sight == Sight::hit;
      through += sight == Sight::through;
      if (hits + through == views_asked) break;
    }
    if (hits + through == 0)
      total.unknown += 1;
    else if (through > hits)
      violated.push_back(p);
    else
      total.seen += 1;
  }
  count_violations(violated, companion_leaves * leaf_m, total);
  return total;
}

}  // namespace headframe
