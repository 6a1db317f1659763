#include "server/atlas/relax.hpp"

#include "server/atlas/pose_graph.hpp"

namespace headframe {
namespace {

/// Information of a transform to b's frame at p_b: a metre there counts as much as 0.05 rad.
Matrix6d information_at(const Eigen::Vector3d& p_b) {
  Vector6d weight;
  weight << 400, 400, 400, 1, 1, 1;
  Matrix6d step = Matrix6d::Identity();  // how a step of b's frame, rotation first, moves p_b
  step.bottomLeftCorner<3, 3>() = -skew(p_b);
  return step.transpose() * weight.asDiagonal() * step;
}

}  // namespace

std::map<SessionId, std::pair<SessionId, Pose>> frozen_together(const Frames& frames, const FrozenSessions& frozen) {
  std::map<SessionId, const FrozenSession*> first_of;  // by frame
  std::map<SessionId, std::pair<SessionId, Pose>> tied;
  for (const auto& [session, T] : frames) {
    const auto found = frozen.find(session);
    if (found == frozen.end()) continue;
    const FrozenSession& held = found->second;
    const auto [first, is_first] = first_of.try_emplace(held.frame, &held);
    if (is_first) continue;
    tied[session] = {first->second->session, first->second->T_frame_session.inverse() * held.T_frame_session};
  }
  return tied;
}

void relax(Frames& frames, const std::vector<Alignment>& edges, const FrozenSessions& frozen, const Meetings& meet) {
  constexpr double stiff = 1e8;  // what they still yield is removed below
  PoseGraph graph;
  std::map<SessionId, std::size_t> node;
  const auto tied = frozen_together(frames, frozen);
  for (const auto& [session, T] : frames) {
    node[session] = graph.nodes.size();
    graph.nodes.push_back({T, graph.nodes.empty()});
  }
  for (const auto& [session, tie] : tied)
    graph.edges.push_back({node.at(tie.first), node.at(session), tie.second, stiff * Matrix6d::Identity()});
  const auto held_by = [&](SessionId session) {
    const auto tie = tied.find(session);
    return tie == tied.end() ? session : tie->second.first;
  };
  for (const Alignment& edge : edges) {
    if (held_by(edge.a) == held_by(edge.b)) continue;
    const Matrix6d information = information_at(meet ? meet(edge) : Eigen::Vector3d::Zero());
    graph.edges.push_back({node.at(edge.a), node.at(edge.b), edge.T_a_b, information});
  }
  const PoseGraphResult result = optimise(graph);
  for (auto& [session, T] : frames) T = orthonormalised(result.T_graph_node[node.at(session)]);
  for (const auto& [session, tie] : tied) frames[session] = orthonormalised(frames.at(tie.first) * tie.second);
}

}  // namespace headframe
