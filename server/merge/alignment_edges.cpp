#include "server/merge/alignment_edges.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "server/atlas/pose_graph.hpp"
#include "server/session/same_placement.hpp"

namespace headframe {
namespace {

constexpr double meet_within_m = 10;
constexpr double degree = std::numbers::pi / 180;

struct KeyframePair {
  std::size_t a = 0, b = 0;
  double distance_m = std::numeric_limits<double>::max();
};

/// Each keyframe of b with the one of a that lies nearest to it, where they meet; the nearest pair where they never do.
std::vector<KeyframePair> meetings(const Session& a, const Session& b, const Pose& T_a_b) {
  std::vector<KeyframePair> out;
  KeyframePair nearest;
  for (std::size_t k = 0; k < b.keyframes.size(); ++k) {
    const Eigen::Vector3d p = T_a_b * b.keyframes[k].T_local_sensor.translation();
    KeyframePair here{0, k};
    for (std::size_t i = 0; i < a.keyframes.size(); ++i) {
      const double m = (a.keyframes[i].T_local_sensor.translation() - p).norm();
      if (m < here.distance_m) here = {i, k, m};
    }
    if (here.distance_m < nearest.distance_m) nearest = here;
    if (here.distance_m <= meet_within_m) out.push_back(here);
  }
  if (out.empty() && nearest.distance_m < std::numeric_limits<double>::max()) out.push_back(nearest);
  return out;
}

/// Evenly along the path, in the frame of the other.
std::vector<Eigen::Vector3d> some_of(const Session& session, const Pose& T) {
  constexpr std::size_t enough = 100;
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; i < session.keyframes.size();
       i += std::max<std::size_t>(1, session.keyframes.size() / enough))
    out.push_back(T * session.keyframes[i].T_local_sensor.translation());
  return out;
}

double spacing_m(const Session& session, std::size_t count) {
  return session.path_m() / static_cast<double>(std::max<std::size_t>(1, count));
}

}  // namespace

Eigen::Vector3d where_they_meet(const Session& a, const Session& b, const Pose& T_a_b) {
  const std::vector<Eigen::Vector3d> of_a = some_of(a, T_a_b.inverse()), of_b = some_of(b, Pose::Identity());
  const double reach_m = meet_within_m + std::max(spacing_m(a, of_a.size()), spacing_m(b, of_b.size())) / 2;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), nearest = Eigen::Vector3d::Zero();
  double count = 0, nearest_m = std::numeric_limits<double>::max();
  const auto look = [&](const std::vector<Eigen::Vector3d>& path, const std::vector<Eigen::Vector3d>& other) {
    for (const Eigen::Vector3d& p : path) {
      double least_m = std::numeric_limits<double>::max();
      for (const Eigen::Vector3d& q : other) {
        const double m = (q - p).norm();
        if (m < nearest_m) nearest_m = m, nearest = (p + q) / 2;
        least_m = std::min(least_m, m);
      }
      if (least_m > reach_m) continue;
      sum += p;
      ++count;
    }
  };
  look(of_a, of_b);
  look(of_b, of_a);
  return count > 0 ? Eigen::Vector3d(sum / count) : nearest;
}

Pose session_transform(const PoseConstraint& place, const Session& a, const Session& b) {
  return a.keyframes.at(place.from.sequence - 1).T_local_sensor * place.T_from_to *
         b.keyframes.at(place.to.sequence - 1).T_local_sensor.inverse();
}

std::vector<PoseConstraint> known_closures(const PoseConstraints& places, const Session& a, const Session& b) {
  const auto known = [](const Session& session, const KeyframeRef& k) {
    return k.sequence >= 1 && k.sequence <= session.keyframes.size();
  };
  std::vector<PoseConstraint> out;
  if (places)
    for (const PoseConstraint& place : *places)
      if (known(a, place.from) && known(b, place.to)) out.push_back(place);
  return out;
}

std::vector<PoseConstraint> edges_of(const Alignment& alignment, const PoseConstraints& places,
                                     const SessionMap& sessions) {
  const Session &a = sessions.at(alignment.a), &b = sessions.at(alignment.b);
  std::vector<PoseConstraint> edges = known_closures(places, a, b);
  const auto of_this = [&](const PoseConstraint& c) {  // they lie apart by the drift between them, but one is near
    return same_placement(session_transform(c, a, b), alignment.T_a_b,
                          b.keyframes[c.to.sequence - 1].T_local_sensor.translation(), same_as_rival);
  };
  if (std::none_of(edges.begin(), edges.end(), of_this)) edges.clear();
  const auto add = [&](const KeyframePair& pair, const Matrix6d& information) {
    const Keyframe &from = a.keyframes[pair.a], &to = b.keyframes[pair.b];
    const Eigen::Vector3d here = alignment.T_a_b * to.T_local_sensor.translation();
    edges.push_back(constraint_between({alignment.a, from.sequence}, from.T_local_sensor, {alignment.b, to.sequence},
                                       to.T_local_sensor, PlaceFit{alignment.T_a_b, here, information}));
  };
  const std::vector<KeyframePair> meet = meetings(a, b, alignment.T_a_b);
  if (meet.empty()) return edges;
  if (edges.empty())
    for (const KeyframePair& end : {meet.front(), meet.back()}) add(end, information_of(1 * degree, 0.3));
  add(meet[meet.size() / 2], information_of(2 * degree, 0.5));
  return edges;
}

}  // namespace headframe
