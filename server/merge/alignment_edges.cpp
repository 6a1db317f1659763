#include "server/merge/alignment_edges.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <limits>
#include <numbers>

#include "server/atlas/pose_graph.hpp"
#include "server/session/same_placement.hpp"
#include "server/verification/meeting.hpp"

namespace headframe {
namespace {

constexpr double meet_within_m = 10;
constexpr double seen_m = 5;  // radius around a keyframe within which a change of its pose should be right
constexpr double degree = std::numbers::pi / 180;

struct KeyframePair {
  std::size_t a = 0, b = 0;
  double distance_m = std::numeric_limits<double>::max();
};

/// Each keyframe of b that comes near a's path, with the nearest keyframe of a; if there is none, the nearest pair.
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

/// Evenly along the path.
std::vector<KeyframePosition> some_of(const Session& session) {
  constexpr std::size_t enough = 100;
  std::vector<KeyframePosition> out;
  const std::size_t step = std::max<std::size_t>(1, session.keyframes.size() / enough);
  for (std::size_t i = 0; i < session.keyframes.size(); i += step)
    out.push_back({i, session.keyframes[i].T_local_sensor.translation()});
  return out;
}

}  // namespace

Eigen::Vector3d where_they_meet(const Session& a, const Session& b, const Pose& T_a_b) {
  const Pose T_b_a = T_a_b.inverse();
  const std::vector<KeyframePosition> of_a = some_of(a), of_b = some_of(b);
  if (of_a.empty() || of_b.empty()) return Eigen::Vector3d::Zero();
  const auto spacing_m = [](const Session& s, const auto& some) {
    return s.path_m() / static_cast<double>(some.size());
  };
  const double reach_m = meet_within_m + std::max(spacing_m(a, of_a), spacing_m(b, of_b)) / 2;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  const auto add = [&](const Eigen::Vector3d& p) { sum += p, ++count; };
  for (const KeyframePosition& s : near_other(of_a, of_b, T_a_b, reach_m)) add(s.p);
  for (const KeyframePosition& s : near_other(of_b, of_a, T_b_a, reach_m)) add(T_b_a * s.p);
  if (count > 0) return sum / count;
  NearestPosition nearest;
  Eigen::Vector3d half_way = Eigen::Vector3d::Zero();
  for (const KeyframePosition& s : of_b) {
    const NearestPosition other = nearest_to(of_a, T_a_b * s.p);
    if (other.distance_m < nearest.distance_m) nearest = other, half_way = (s.p + T_b_a * other.position->p) / 2;
  }
  return half_way;
}

Pose T_was_now_where_they_meet(const Session& was, std::span<const Keyframe> now, const Session& other,
                               const Pose& T_other_was) {
  std::vector<KeyframePair> meet = meetings(other, was, T_other_was);
  std::erase_if(meet, [&](const KeyframePair& pair) { return pair.b >= now.size(); });
  Pose T_was_now = Pose::Identity();
  if (meet.empty()) return T_was_now;
  Eigen::Vector3d middle_was = Eigen::Vector3d::Zero(), middle_now = Eigen::Vector3d::Zero();
  for (const KeyframePair& pair : meet) {
    middle_was += position(was.keyframes[pair.b]) / static_cast<double>(meet.size());
    middle_now += position(now[pair.b]) / static_cast<double>(meet.size());
  }
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();  // of the keyframes' positions, and of points around each keyframe
  for (const KeyframePair& pair : meet) {
    const Keyframe &k_was = was.keyframes[pair.b], &k_now = now[pair.b];
    turns += (position(k_was) - middle_was) * (position(k_now) - middle_now).transpose();
    turns += seen_m * seen_m * k_was.T_local_sensor.linear() * k_now.T_local_sensor.linear().transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turns, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) *= -1;  // a rotation, not a reflection
  T_was_now.linear() = U * svd.matrixV().transpose();
  T_was_now.translation() = middle_was - T_was_now.linear() * middle_now;
  return T_was_now;
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
  const auto of_this = [&](const PoseConstraint& c) {  // they differ by drift, but one of them has to be near
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
