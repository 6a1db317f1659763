#include "server/atlas/relax.hpp"

#include "server/atlas/pose_graph.hpp"

namespace headframe {

void relax(Frames& frames, const std::vector<Alignment>& edges) {
  PoseGraph graph;
  std::map<SessionId, std::size_t> node;
  for (const auto& [session, T] : frames) {
    node[session] = graph.nodes.size();
    graph.nodes.push_back({T, graph.nodes.empty()});
  }
  Vector6d weight;
  weight << 400, 400, 400, 1, 1, 1;
  for (const Alignment& edge : edges)
    graph.edges.push_back({node.at(edge.a), node.at(edge.b), edge.T_a_b, weight.asDiagonal()});
  const PoseGraphResult result = optimise(graph);
  for (auto& [session, T] : frames) T = orthonormalised(result.T_graph_node[node.at(session)]);
}

}  // namespace headframe
