#include "server/registration/visibility.hpp"

#include "server/registration/parallel.hpp"

namespace headframe {

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
  constexpr std::size_t block_points = 512;
  std::vector<Visibility> sums((points_b.size() + block_points - 1) / block_points);
  for_blocks(points_b.size(), block_points, threads, [&](std::size_t begin, std::size_t end, std::size_t block) {
    for (std::size_t i = begin; i < end; ++i) {
      int hits = 0, through = 0;
      for (const View& view : views) {
        if ((view.origin_b - points_b[i]).squaredNorm() > reach_m * reach_m) continue;
        const Sight sight = view.image->look(view.T_view_b * points_b[i], reach_m);
        hits += sight == Sight::hit;
        through += sight == Sight::through;
      }
      if (hits == 0 && through == 0)
        sums[block].unknown += 1;
      else if (through > hits)
        sums[block].violated += 1;
      else
        sums[block].seen += 1;
    }
  });
  Visibility total;
  for (const Visibility& s : sums) {
    total.seen += s.seen;
    total.violated += s.violated;
    total.unknown += s.unknown;
  }
  return total;
}

}  // namespace headframe
