#include "server/registration/visibility.hpp"

#include "server/registration/kd_tree.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr std::size_t companions = 3;
constexpr float companion_reach_m = 0.9F;

Visibility count(const Points& points, const std::vector<Sight>& sights) {
  Visibility total;
  Points violated;
  for (std::size_t i = 0; i < points.size(); ++i) {
    total.seen += sights[i] == Sight::hit;
    total.unknown += sights[i] == Sight::unknown;
    if (sights[i] == Sight::through) violated.push_back(points[i]);
  }
  const KdTree tree(violated);
  std::vector<Neighbour> around;
  for (const auto& p : violated) {
    tree.nearest_k(p, companions + 1, around);  // itself among them
    const bool patch = around.size() > companions && around.back().squared_m < companion_reach_m * companion_reach_m;
    (patch ? total.violated : total.lone) += 1;
  }
  return total;
}

}  // namespace

Visibility& Visibility::operator+=(const Visibility& other) {
  seen += other.seen;
  violated += other.violated;
  lone += other.lone;
  unknown += other.unknown;
  return *this;
}

Visibility look_from(std::span<const PlacedCloud> a, const Points& points_b, const Pose& T_a_b, float reach_m,
                     int threads) {
  struct View {
    Eigen::Isometry3f T_view_b;
    Eigen::Vector3f origin_b;
    const RangeImage* image;
  };
  std::vector<View> views;
  for (const PlacedCloud& c : a)
    for (const auto& view : c.cloud->views) {
      const Pose T_b_view = T_a_b.inverse() * c.T_local_sensor * Eigen::Translation3d(view.origin.cast<double>());
      views.push_back({T_b_view.inverse().cast<float>(), T_b_view.translation().cast<float>(), &view.image});
    }
  std::vector<Sight> sights(points_b.size(), Sight::unknown);
  for_blocks(points_b.size(), 512, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      int hits = 0, through = 0;
      for (const View& view : views) {
        if ((view.origin_b - points_b[i]).squaredNorm() > reach_m * reach_m) continue;
        const Sight sight = view.image->look(view.T_view_b * points_b[i], reach_m);
        hits += sight == Sight::hit;
        through += sight == Sight::through;
      }
      if (hits > 0 || through > 0) sights[i] = through > hits ? Sight::through : Sight::hit;
    }
  });
  return count(points_b, sights);
}

}  // namespace headframe
