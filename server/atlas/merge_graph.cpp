#include "server/atlas/merge_graph.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace headframe {
namespace {

using Pair = std::pair<SessionId, SessionId>;  // first < second

/// Sessions of one component with their poses relative to some member.
using Frames = std::map<SessionId, Pose>;

struct Growing {
  std::map<SessionId, std::size_t> component_of;
  std::vector<Frames> components;

  explicit Growing(std::span<const SessionId> sessions) {
    for (const SessionId s : sessions) {
      component_of[s] = components.size();
      components.push_back({{s, Pose::Identity()}});
    }
  }

  void join(const Alignment& alignment) {
    const std::size_t into = component_of[alignment.a], from = component_of[alignment.b];
    const Pose T_into_from = joining(alignment);
    for (const auto& [session, T] : components[from]) {
      components[into][session] = T_into_from * T;
      component_of[session] = into;
    }
    components[from].clear();
  }

  /// Of the component of b in that of a.
  Pose joining(const Alignment& alignment) {
    return components[component_of[alignment.a]][alignment.a] * alignment.T_a_b *
           components[component_of[alignment.b]][alignment.b].inverse();
  }

  /// What the sessions of both components say of it, but for those that have an alignment to speak for them.
  struct Met {
    Contact contact = Contact::none;
    Pair by;
  };
  Met met(const Alignment& alignment, const std::set<Pair>& aligned, const Contacts& contacts) {
    Met worst;
    const Pose T_into_from = joining(alignment);
    for (const auto& [x, T_x] : components[component_of[alignment.a]])
      for (const auto& [y, T_y] : components[component_of[alignment.b]]) {
        const Pair pair = std::minmax(x, y);
        if (aligned.contains(pair)) continue;
        const Pose T_x_y = T_x.inverse() * T_into_from * T_y;
        const Contact contact = contacts(pair.first, pair.second, x < y ? T_x_y : T_x_y.inverse());
        if (contact == Contact::contradicts) return {contact, pair};
        if (contact == Contact::unknown) worst = {contact, pair};
      }
    return worst;
  }

  Pose T_a_b(const Alignment& alignment) {
    Frames& frames = components[component_of[alignment.a]];
    return frames[alignment.a].inverse() * frames[alignment.b];
  }
};

bool usable(const Alignment& k) { return k.state == AlignmentState::verified || k.state == AlignmentState::published; }

/// Of each alignment: in how many triangles of usable ones it closes, less those that it does not. A wrong one fails
/// with every third session that both know, a right one only with those that the wrong one spoils.
std::vector<int> triangle_votes(std::span<const Alignment> alignments, const LoopTolerance& tolerance) {
  std::map<SessionId, std::map<SessionId, std::size_t>> between;  // [a][b], a < b
  for (std::size_t i = 0; i < alignments.size(); ++i)
    if (usable(alignments[i])) between[alignments[i].a][alignments[i].b] = i;
  std::vector<int> votes(alignments.size(), 0);
  for (const auto& [a, from_a] : between)
    for (const auto& [b, ab] : from_a) {
      const auto from_b = between.find(b);
      if (from_b == between.end()) continue;
      for (const auto& [c, bc] : from_b->second) {
        const auto ac = from_a.find(c);
        if (ac == from_a.end()) continue;
        const Pose T_a_c = alignments[ab].T_a_b * alignments[bc].T_a_b;
        const int vote = agrees(T_a_c, alignments[ac->second].T_a_b, tolerance) ? 1 : -1;
        for (const std::size_t i : {ab, bc, ac->second}) votes[i] += vote;
      }
    }
  return votes;
}

/// Indices of the usable ones, the strongest first.
std::vector<std::size_t> by_strength(std::span<const Alignment> alignments, const LoopTolerance& tolerance) {
  const std::vector<int> votes = triangle_votes(alignments, tolerance);
  std::vector<std::size_t> order;
  order.reserve(alignments.size());
  for (std::size_t i = 0; i < alignments.size(); ++i)
    if (usable(alignments[i])) order.push_back(i);
  const auto rank = [&](std::size_t i) {
    const Alignment& k = alignments[i];
    // Two placements of one piece of a session share its aliases: they do not tell which of them is right.
    const double sure = std::max(k.evidence.probability, k.evidence.probability_if_unique) * (1 - k.evidence.runner_up);
    return std::tuple(k.ruling != Ruling::confirmed, -votes[i], -sure, -k.evidence.seen_points, k.a, k.b);
  };
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return rank(i) < rank(j); });
  return order;
}

/// Gauss-Newton over the session frames of one component (the first stays), each alignment with equal weight: a metre
/// counts as much as 0.05 rad.
void relax(Frames& frames, const std::vector<Alignment>& edges) {
  std::map<SessionId, Eigen::Index> column;
  for (const auto& [session, T] : frames) column[session] = 6 * (static_cast<Eigen::Index>(column.size()) - 1);
  const Eigen::Index n = 6 * (static_cast<Eigen::Index>(frames.size()) - 1);
  Vector6d weight;
  weight << 400, 400, 400, 1, 1, 1;
  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    for (const Alignment& edge : edges) {
      // r = log(T_a_b^-1 T_a^-1 T_b); right increments: T_b moves r by d_b, T_a by -Ad(T_b^-1 T_a) d_a, to first order.
      const Pose T_b_a = frames[edge.b].inverse() * frames[edge.a];
      const Vector6d r = se3_log(edge.T_a_b.inverse() * T_b_a.inverse());
      Eigen::Matrix<double, 6, 6> J_a = Eigen::Matrix<double, 6, 6>::Zero();
      J_a.topLeftCorner<3, 3>() = J_a.bottomRightCorner<3, 3>() = -T_b_a.linear();
      J_a.bottomLeftCorner<3, 3>() = -skew(T_b_a.translation()) * T_b_a.linear();
      const Eigen::Index a = column[edge.a], b = column[edge.b];
      const Eigen::Matrix<double, 6, 6> W = weight.asDiagonal();
      if (a >= 0) {
        H.block<6, 6>(a, a) += J_a.transpose() * W * J_a;
        g.segment<6>(a) += J_a.transpose() * W * r;
      }
      if (b >= 0) {
        H.block<6, 6>(b, b) += W;
        g.segment<6>(b) += W * r;
      }
      if (a >= 0 && b >= 0) {
        H.block<6, 6>(a, b) += J_a.transpose() * W;
        H.block<6, 6>(b, a) += W * J_a;
      }
    }
    H.diagonal().array() += 1e-9;
    const Eigen::VectorXd d = -H.ldlt().solve(g);
    for (auto& [session, T] : frames)
      if (column[session] >= 0) T = orthonormalised(T * se3_exp(d.segment<6>(column[session])));
    if (d.norm() < 1e-9) break;
  }
}

Component component_from(const Frames& frames, std::span<const SessionId> anchors) {
  const auto chosen = std::find_if(anchors.rbegin(), anchors.rend(), [&](SessionId id) { return frames.contains(id); });
  const auto anchor = chosen == anchors.rend() ? frames.begin() : frames.find(*chosen);
  Component component;
  component.id = anchor->first;
  const Pose T_component = anchor->second.inverse();
  for (const auto& [session, T] : frames)
    component.placements.push_back(
        {session, session == component.id ? Pose::Identity() : orthonormalised(T_component * T)});
  return component;
}

}  // namespace

bool agrees(const Pose& T_loop, const Pose& T, const LoopTolerance& tolerance) {
  const Pose error = T_loop.inverse() * T;
  return rotation_angle_rad(error) < tolerance.rotation_rad &&
         error.translation().norm() < tolerance.translation_m + 0.01 * T.translation().norm();
}

MergeResult merge_sessions(std::span<const SessionId> sessions, std::span<const Alignment> alignments,
                           const LoopTolerance& tolerance, std::span<const SessionId> anchors,
                           const Contacts& contacts) {
  MergeResult result;
  for (const Alignment& alignment : alignments) result.states.push_back(alignment.state);
  result.contradicted_by.resize(alignments.size());
  std::set<Pair> aligned;
  for (const Alignment& alignment : alignments)
    if (usable(alignment)) aligned.emplace(alignment.a, alignment.b);
  Growing growing(sessions);
  std::vector<Alignment> published;
  for (const std::size_t i : by_strength(alignments, tolerance)) {
    const Alignment& alignment = alignments[i];
    const bool loop = growing.component_of.at(alignment.a) == growing.component_of.at(alignment.b);
    bool admitted = true;
    if (loop) {
      admitted = agrees(growing.T_a_b(alignment), alignment.T_a_b, tolerance);
    } else if (contacts && alignment.ruling != Ruling::confirmed) {
      const Growing::Met met = growing.met(alignment, aligned, contacts);
      if (met.contact == Contact::contradicts) result.contradicted_by[i] = met.by;
      const bool waits = met.contact == Contact::unknown && alignment.state != AlignmentState::published;
      admitted = met.contact != Contact::contradicts && !waits;
    }
    if (!admitted) {
      // A confirmed one waits: it comes back when what it contradicts is retracted.
      const bool waits = alignment.ruling == Ruling::confirmed || alignment.state != AlignmentState::published;
      result.states[i] = waits ? AlignmentState::verified : AlignmentState::retracted;
      continue;
    }
    if (!loop) growing.join(alignment);
    result.states[i] = AlignmentState::published;
    published.push_back(alignment);
  }
  for (Frames& frames : growing.components) {
    if (frames.empty()) continue;
    std::vector<Alignment> edges;
    for (const Alignment& alignment : published)
      if (frames.contains(alignment.a)) edges.push_back(alignment);
    if (edges.size() >= frames.size()) relax(frames, edges);
    result.components.push_back(component_from(frames, anchors));
  }
  std::sort(result.components.begin(), result.components.end(),
            [](const auto& x, const auto& y) { return x.id < y.id; });
  return result;
}

}  // namespace headframe
