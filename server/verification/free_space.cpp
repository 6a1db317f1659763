#include "server/verification/free_space.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "server/registration/kd_tree.hpp"
#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr std::size_t companions = 3;
constexpr float companion_leaves = 1.8F;
constexpr int least_hits = 2;         // by its own session; a point that only one sweep hit may be dust
constexpr float least_cosine = 0.3F;  // of ray and normal; rays that graze a surface do not count

/// A violated point is part of a patch if others lie within reach.
void tell_lone_ones(const SurfelCloud& rock, float reach_m, std::vector<PointSight>& sights) {
  Points violated;
  for (std::size_t i = 0; i < sights.size(); ++i)
    if (sights[i] == PointSight::violated) violated.push_back(rock.points[i]);
  const KdTree tree(violated);
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (sights[i] != PointSight::violated) continue;
    const bool patch = tree.has_within(rock.points[i], reach_m, companions + 1);  // itself among them
    if (!patch) sights[i] = PointSight::lone;
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
    for (const auto& view : *c.cloud->views) {
      const Pose T = c.T_local_sensor * Eigen::Translation3d(view.origin.cast<double>());
      if (const double d = (T.translation() - centre).norm(); d < reach_m)
        near.push_back({d, {T, {c.cloud->views, &view.image}}});
    }
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  std::vector<PlacedView> views;
  views.reserve(near.size());
  for (const auto& [distance, view] : near) views.push_back(view);
  return views;
}

namespace {

struct View {
  Eigen::Isometry3f T_view_points;
  Eigen::Vector3f origin;
  const SightImage* image;
};

std::vector<View> seen_from(std::span<const PlacedView> placed, const Pose& T_placed_points) {
  std::vector<View> views;
  views.reserve(placed.size());
  for (const PlacedView& view : placed) {
    const Pose T_points_view = T_placed_points.inverse() * view.T_local_view;
    views.push_back(
        {T_points_view.inverse().cast<float>(), T_points_view.translation().cast<float>(), view.image.get()});
  }
  return views;
}

struct Answer {
  int hits = 0, through = 0;
};

/// The first eight views that know anything of a point decide by majority: with so many answers of one kind it is
/// settled, whatever the others say. With four of each, another session's point counts as hit, its own as seen through.
constexpr Answer settles_anothers{4, 5}, settles_its_own{5, 4};

HEADFRAME_WIDE void move(const Eigen::Matrix4f& T, SightBlock& points) {
  float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  for (std::size_t i = 0; i < points.count; ++i) {
    const float px = x[i], py = y[i], pz = z[i];
    x[i] = T(0, 0) * px + T(0, 1) * py + T(0, 2) * pz + T(0, 3);
    y[i] = T(1, 0) * px + T(1, 1) * py + T(1, 2) * pz + T(1, 3);
    z[i] = T(2, 0) * px + T(2, 1) * py + T(2, 2) * pz + T(2, 3);
  }
}

void look(const View& view, const Points& points, std::span<const std::uint32_t> numbers, float reach_m, float slack_m,
          std::array<Sight, SightBlock::most>& sights) {
  SightBlock block;
  for (const std::uint32_t n : numbers) block.add(points[n]);
  move(view.T_view_points.matrix(), block);
  view.image->look(block, reach_m, sights, slack_m);
}

/// What the views say of each point until it is settled; view by view, so that an image stays in the processor's cache.
std::vector<Answer> ask(const std::vector<View>& views, const SurfelCloud& rock, float reach_m, Answer settles,
                        float slack_m = 0) {
  std::vector<Answer> answers(rock.points.size());
  std::vector<std::uint32_t> open(rock.points.size());  // points of which more may be said
  std::iota(open.begin(), open.end(), 0);
  std::array<Sight, SightBlock::most> sights;
  std::array<std::uint8_t, SightBlock::most> known;  // points of a block of which the view knows something
  for (const View& view : views) {
    std::size_t still_open = 0;
    for (std::size_t first = 0; first < open.size(); first += sights.size()) {
      const auto block = std::span(open).subspan(first, std::min(sights.size(), open.size() - first));
      look(view, rock.points, block, reach_m, slack_m, sights);
      std::size_t count = 0;
      for (std::size_t i = 0; i < block.size(); ++i) {
        known[count] = static_cast<std::uint8_t>(i);
        count += static_cast<std::size_t>(sights[i] != Sight::unknown);
      }
      for (const std::uint8_t i : std::span(known).first(count)) {
        const std::uint32_t n = block[i];
        const Eigen::Vector3f ray = rock.points[n] - view.origin;
        const float range = ray.norm();
        const int within = static_cast<int>(range <= reach_m),
                  faces = static_cast<int>(std::abs(rock.normals[n].dot(ray)) > least_cosine * range);
        answers[n].hits += within & static_cast<int>(sights[i] == Sight::hit);
        answers[n].through += within & faces & static_cast<int>(sights[i] == Sight::through);
      }
      for (const std::uint32_t n : block) {
        open[still_open] = n;
        still_open += static_cast<std::size_t>(answers[n].hits < settles.hits && answers[n].through < settles.through);
      }
    }
    open.resize(still_open);
  }
  return answers;
}

}  // namespace

SurfelCloud without_transients(const SurfelCloud& surfels, std::span<const PlacedView> own, float reach_m) {
  const std::vector<View> views = seen_from(own, Pose::Identity());
  SurfelCloud kept;
  const std::vector<Answer> answers = ask(views, surfels, reach_m, settles_its_own);
  for (std::size_t i = 0; i < surfels.points.size(); ++i) {
    if (is_transient(answers[i].hits, answers[i].through, least_hits)) continue;
    kept.points.push_back(surfels.points[i]);
    kept.normals.push_back(surfels.normals[i]);
  }
  return kept;
}

std::vector<PointSight> sights_from(std::span<const PlacedView> a, const SurfelCloud& b, const Pose& T_a_b,
                                    float reach_m, float leaf_m, float slack_m) {
  const std::vector<View> views = seen_from(a, T_a_b);
  std::vector<PointSight> sights;
  sights.reserve(b.points.size());
  for (const Answer& answer : ask(views, b, reach_m, settles_anothers, slack_m))
    sights.push_back(answer.hits + answer.through == 0 ? PointSight::unknown
                     : answer.through > answer.hits    ? PointSight::violated
                                                       : PointSight::seen);
  tell_lone_ones(b, companion_leaves * leaf_m, sights);
  return sights;
}

Visibility summed_up(std::span<const PointSight> sights) {
  const auto count = [&](PointSight of) { return static_cast<double>(std::count(sights.begin(), sights.end(), of)); };
  return {count(PointSight::seen), count(PointSight::violated), count(PointSight::lone), count(PointSight::unknown)};
}

}  // namespace headframe
