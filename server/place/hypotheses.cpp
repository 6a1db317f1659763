#include "server/place/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headframe {
namespace {

constexpr std::size_t placements_per_piece_pair = 20;
constexpr std::size_t votes_kept = 5;
constexpr double same_vote_m = 4, same_vote_rad = 0.26;  // 15 deg

Eigen::Vector3d place(const Keyframe& keyframe) { return keyframe.T_local_sensor.translation(); }

/// Height of b's frame in a's, from the two keyframes that the placement brings nearest to each other.
double height_m(std::span<const Keyframe> a, std::span<const Keyframe> b, const Pose& T_a_b) {
  double nearest = std::numeric_limits<double>::max(), height = 0;
  for (const Keyframe& k : b) {
    const Eigen::Vector3d p = T_a_b * place(k);
    for (const Keyframe& l : a) {
      const Eigen::Vector3d d = place(l) - p;
      if (d.head<2>().squaredNorm() >= nearest) continue;
      nearest = d.head<2>().squaredNorm();
      height = d.z();
    }
  }
  return height;
}

bool same(const Pose& T, const Pose& U, const Eigen::Vector3d& at) {
  return (T * at - U * at).norm() < same_vote_m && std::abs(wrap_rad(yaw_rad(T) - yaw_rad(U))) < same_vote_rad;
}

/// Votes of matched pairs: each T_0 weighs 1 / (1 + how many of b's matches meet the same keyframe of a), since a place
/// that looks like many others says little. The best clusters come first.
std::vector<Pose> vote(std::span<const Keyframe> a, std::span<const Keyframe> b, std::span<const MatchedPair> matches,
                       const DescriptorFamily& family) {
  std::vector<int> popular(a.size(), 0);
  for (const MatchedPair& m : matches) ++popular[m.a];
  struct Vote {
    Pose T;
    Eigen::Vector3d at;
    double weight;
  };
  std::vector<Vote> votes;
  for (const MatchedPair& m : matches)
    for (const Pose& T : initial_transforms(a[m.a], b[m.b], family, 2))
      votes.push_back({T, place(b[m.b]), 1.0 / popular[m.a]});
  std::vector<Pose> best;
  std::vector<bool> used(votes.size(), false);
  while (best.size() < votes_kept) {
    double most = 0;
    std::size_t winner = votes.size();
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (used[i]) continue;
      double sum = 0;
      for (std::size_t j = 0; j < votes.size(); ++j)
        if (!used[j] && same(votes[i].T, votes[j].T, votes[j].at)) sum += votes[j].weight;
      if (sum > most) {
        most = sum;
        winner = i;
      }
    }
    if (winner == votes.size()) break;
    best.push_back(votes[winner].T);
    for (std::size_t j = 0; j < votes.size(); ++j)
      if (same(votes[winner].T, votes[j].T, votes[j].at)) used[j] = true;
  }
  return best;
}

/// Votes, and the paper's single nearest pair, scored by the wall maps of both whole sessions.
void add_from_descriptors(std::span<const Keyframe> a, std::span<const Keyframe> b,
                          std::span<const MatchedPair> matches, const DescriptorFamily& family, float cell_m,
                          std::vector<Hypothesis>& out) {
  const auto argmin = std::min_element(matches.begin(), matches.end(), [](const auto& m, const auto& n) {
    return m.squared_distance < n.squared_distance;
  });
  std::vector<Pose> found = vote(a, b, matches, family);
  for (const Pose& T : initial_transforms(a[argmin->a], b[argmin->b], family, 1)) found.push_back(T);
  const WallMap map_a = draw_wall_map(a, cell_m), map_b = draw_wall_map(b, cell_m);
  for (const Pose& T : found) {
    const WallMatch m = refine_old(map_a, map_b, {yaw_rad(T), T.translation().head<2>(), 0});
    out.push_back({pose_from_yaw(m.yaw_rad, {m.shift_m.x(), m.shift_m.y(), T.translation().z()}), m.score});
  }
}

}  // namespace

std::vector<Piece> cut_pieces(std::span<const Keyframe> keyframes, double piece_m) {
  std::vector<double> path(keyframes.size(), 0);
  for (std::size_t i = 1; i < path.size(); ++i)
    path[i] = path[i - 1] + (place(keyframes[i]) - place(keyframes[i - 1])).norm();
  std::vector<Piece> pieces;
  const auto index = [&](double at) {
    return static_cast<std::size_t>(std::lower_bound(path.begin(), path.end(), at) - path.begin());
  };
  for (double at = 0; !keyframes.empty(); at += piece_m / 2) {
    pieces.push_back({index(at), std::min(keyframes.size(), index(at + piece_m) + 1)});
    if (pieces.back().end == keyframes.size()) break;
  }
  return pieces;
}

std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, const DescriptorFamily& family,
                                     std::size_t most_yaws) {
  std::vector<Pose> out;
  for (const YawScore& yaw : family.yaw_difference(a.descriptor.w, b.descriptor.w, most_yaws))
    out.push_back(levelled(a.T_local_sensor) * pose_from_yaw(yaw.yaw_rad, Eigen::Vector3d::Zero()) *
                  levelled(b.T_local_sensor).inverse());
  return out;
}

HypothesisFinder::Correlated HypothesisFinder::correlate_pieces(std::span<const Keyframe> a, Piece piece_a,
                                                                std::span<const Keyframe> b, Piece piece_b) const {
  const auto part_a = a.subspan(piece_a.begin, piece_a.end - piece_a.begin);
  const auto part_b = b.subspan(piece_b.begin, piece_b.end - piece_b.begin);
  Correlated out{piece_a.end, piece_b.end, {}};
  for (const WallMatch& m : correlate(draw_wall_map(part_a, config_.cell_m), draw_wall_map(part_b, config_.cell_m),
                                      placements_per_piece_pair, config_.threads)) {
    Pose T = pose_from_yaw(m.yaw_rad, {m.shift_m.x(), m.shift_m.y(), 0});
    T.translation().z() = height_m(part_a, part_b, T);
    out.hypotheses.push_back({T, m.score});
  }
  return out;
}

void HypothesisFinder::add_from_walls(SessionId id_a, std::span<const Keyframe> a, SessionId id_b,
                                      std::span<const Keyframe> b, std::span<const MatchedPair> matches,
                                      std::vector<Hypothesis>& out, bool& exhausted) {
  struct Job {
    Piece a, b;
    int matches = 0;
  };
  std::vector<Job> jobs;
  const auto pieces_a = cut_pieces(a, config_.piece_m), pieces_b = cut_pieces(b, config_.piece_m);
  for (const Piece& p : pieces_a)
    for (const Piece& q : pieces_b) {
      const Correlated& known = correlated_[{id_a, id_b, p.begin, q.begin}];
      if (known.end_a == p.end && known.end_b == q.end) continue;
      Job job{p, q};
      for (const MatchedPair& m : matches)
        job.matches += m.a >= p.begin && m.a < p.end && m.b >= q.begin && m.b < q.end;
      jobs.push_back(job);
    }
  std::stable_sort(jobs.begin(), jobs.end(), [](const Job& x, const Job& y) { return x.matches > y.matches; });
  exhausted = jobs.size() <= config_.correlations;
  if (!exhausted) jobs.resize(config_.correlations);
  for (const Job& job : jobs)
    correlated_[{id_a, id_b, job.a.begin, job.b.begin}] = correlate_pieces(a, job.a, b, job.b);
  for (const Piece& p : pieces_a)
    for (const Piece& q : pieces_b) {
      const auto& found = correlated_[{id_a, id_b, p.begin, q.begin}].hypotheses;
      out.insert(out.end(), found.begin(), found.end());
    }
}

std::vector<Hypothesis> HypothesisFinder::find(SessionId id_a, std::span<const Keyframe> a, SessionId id_b,
                                               std::span<const Keyframe> b, std::span<const MatchedPair> matches,
                                               const DescriptorFamily* family, bool& exhausted) {
  exhausted = true;
  if (a.empty() || b.empty()) return {};
  std::vector<Hypothesis> all;
  add_from_walls(id_a, a, id_b, b, matches, all, exhausted);
  if (family && !matches.empty()) add_from_descriptors(a, b, matches, *family, config_.cell_m, all);

  std::stable_sort(all.begin(), all.end(), [](const auto& h, const auto& g) { return h.score > g.score; });
  std::vector<Hypothesis> best;
  const Eigen::Vector3d at = place(b[b.size() / 2]);
  for (const Hypothesis& h : all) {
    if (best.size() == config_.most) break;
    if (std::none_of(best.begin(), best.end(), [&](const auto& g) { return same(g.T_a_b, h.T_a_b, at); }))
      best.push_back(h);
  }
  return best;
}

}  // namespace headframe
