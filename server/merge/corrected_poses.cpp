#include "server/merge/corrected_poses.hpp"

#include <algorithm>
#include <deque>

#include "server/merge/alignment_edges.hpp"
#include "server/merge/frozen_places.hpp"
#include "server/merge/odometry_chain.hpp"

namespace headframe {

/// One component, with the constraints between its sessions.
struct CorrectedPoses::Work {
  SessionId anchor = 0;
  std::map<SessionId, Pose> members;  // T_component_session from merging
  std::vector<const std::vector<PoseConstraint>*> pairs;
  std::map<SessionId, std::vector<const std::vector<PoseConstraint>*>> of;  // by session

  Work(const Component& component, const std::map<Pair, PairEdges>& known) : anchor(component.id) {
    for (const Placement& p : component.placements) members[p.session] = p.T_component_session;
    for (const auto& [pair, edges] : known) {
      if (!members.contains(pair.first) || !members.contains(pair.second) || edges.edges.empty()) continue;
      pairs.push_back(&edges.edges);
      of[pair.first].push_back(pairs.back());
      if (pair.first != pair.second) of[pair.second].push_back(pairs.back());
    }
  }
  std::set<SessionId> with_neighbours(const std::set<SessionId>& sessions) const {
    std::set<SessionId> out = sessions;
    for (const SessionId s : sessions)
      if (const auto found = of.find(s); found != of.end())
        for (const auto* edges : found->second) out.insert({edges->front().from.session, edges->front().to.session});
    return out;
  }
};

namespace {

std::shared_ptr<const Correction> moved(const Correction& correction, SessionId component, const Pose& T) {
  auto out = std::make_shared<Correction>(correction);
  out->component = component;
  for (CorrectedKeyframe& k : out->keyframes) k.T_component_session = orthonormalised(T * k.T_component_session);
  return out;
}

}  // namespace

Pose CorrectedPoses::raw(const KeyframeRef& k) const {
  return sessions_.at(k.session).keyframes.at(k.sequence - 1).T_local_sensor;
}

Pose CorrectedPoses::corrected(const KeyframeRef& k) const {
  return corrections_.at(k.session)->corrected(k.sequence, raw(k));
}

void CorrectedPoses::update(std::span<const Component> components, std::span<const Alignment> alignments) {
  refresh(alignments);
  Corrections kept;
  for (const Component& component : components) {
    Work work(component, pairs_);
    const bool any_frozen = std::any_of(work.members.begin(), work.members.end(),
                                        [&](const auto& member) { return is_frozen(member.first); });
    if (work.pairs.empty() && !any_frozen) continue;  // rigid
    optimise_component(work);
    for (const Placement& p : component.placements) kept[p.session] = corrections_.at(p.session);
  }
  corrections_ = std::move(kept);
  changed_.clear();
  give_out();
}

std::vector<PairClosures> CorrectedPoses::note_moved(SessionId session) {
  const auto is_of = [session](const Pair& pair) { return pair.first == session || pair.second == session; };
  std::erase_if(pairs_, [&](const auto& entry) { return is_of(entry.first); });
  corrections_.erase(session);
  changed_.insert(session);
  std::vector<PairClosures> known;
  for (const auto& [pair, places] : closures_)
    if (is_of(pair) && sessions_.contains(pair.first) && sessions_.contains(pair.second))
      known.push_back({pair.first, pair.second, places});
  return known;
}

void CorrectedPoses::keep(const Pair& pair, PairEdges edges) {
  pairs_[pair] = std::move(edges);
  changed_.insert({pair.first, pair.second});
}

void CorrectedPoses::refresh(std::span<const Alignment> alignments) {
  std::set<Pair> now;
  const auto same = [&](const Pair& pair, const Pose& T_a_b, const PoseConstraints& measured) {
    const auto known = pairs_.find(pair);
    return known != pairs_.end() && known->second.T_a_b.matrix() == T_a_b.matrix() &&
           known->second.measured == measured;
  };
  for (const Alignment& k : alignments) {
    if (k.state != AlignmentState::published || !sessions_.contains(k.a) || !sessions_.contains(k.b)) continue;
    now.emplace(k.a, k.b);
    const auto known = closures_.find({k.a, k.b});
    const PoseConstraints places = known == closures_.end() ? nullptr : known->second;
    if (!same({k.a, k.b}, k.T_a_b, places)) keep({k.a, k.b}, {k.T_a_b, places, edges_of(k, places, sessions_)});
  }
  for (const auto& [pair, places] : closures_) {
    if (pair.first != pair.second || !sessions_.contains(pair.first)) continue;
    now.insert(pair);
    const Session& session = sessions_.at(pair.first);
    if (!same(pair, Pose::Identity(), places))
      keep(pair, {Pose::Identity(), places, known_closures(places, session, session)});
  }
  std::erase_if(pairs_, [&](const auto& entry) {
    if (now.contains(entry.first)) return false;
    changed_.insert({entry.first.first, entry.first.second});
    return true;
  });
}

/// Sessions that were in one component before keep their relative places. Each such group is placed by a constraint to
/// one that is placed already, starting with the anchor's group.
void CorrectedPoses::place_groups(const Work& work) {
  std::map<SessionId, std::vector<SessionId>> groups;  // by the earlier component; a new session: by its negative id
  std::map<SessionId, SessionId> group_of;
  for (const auto& [session, T] : work.members) {
    auto& correction = corrections_[session];
    const bool is_new = !correction;
    if (is_new) {
      changed_.insert(session);
      correction = std::make_shared<const Correction>(Correction{0, {{1, Pose::Identity()}}});
    }
    group_of[session] = is_new ? -session : correction->component;
    groups[group_of[session]].push_back(session);
  }
  std::deque<SessionId> placed;
  std::set<SessionId> done;
  const auto lay = [&](SessionId group, const Pose& T) {
    if (!done.insert(group).second) return;
    const bool stays = T.isApprox(Pose::Identity(), 1e-12);
    for (const SessionId session : groups.at(group)) {
      auto& correction = corrections_[session];
      if (!stays || correction->component != work.anchor) correction = moved(*correction, work.anchor, T);
      placed.push_back(session);
    }
  };
  const auto lay_all_from_there = [&] {
    for (; !placed.empty(); placed.pop_front()) {
      const auto of = work.of.find(placed.front());
      if (of == work.of.end()) continue;
      for (const auto* edges : of->second) {
        const PoseConstraint& c = edges->back();  // the alignment as a whole
        const bool forward = c.from.session == placed.front();
        const KeyframeRef &here = forward ? c.from : c.to, &there = forward ? c.to : c.from;
        if (done.contains(group_of.at(there.session))) continue;
        const Pose T_here_there = forward ? c.T_from_to : c.T_from_to.inverse();
        lay(group_of.at(there.session), corrected(here) * T_here_there * corrected(there).inverse());
      }
    }
  };
  const KeyframeRef first{work.anchor, 1};
  lay(group_of.at(work.anchor), raw(first) * corrected(first).inverse());
  lay_all_from_there();
  for (const auto& [session, T] : work.members) {  // sessions that no constraint reaches
    if (done.contains(group_of.at(session))) continue;
    lay(group_of.at(session), T * corrections_.at(session)->keyframes.front().T_component_session.inverse());
    lay_all_from_there();
  }
}

/// Puts frozen sessions where they were when they were frozen.
void CorrectedPoses::hold_frozen(const Work& work) {
  const auto same = [](const CorrectedKeyframe& k, const CorrectedKeyframe& l) {
    return k.sequence == l.sequence && k.T_component_session.isApprox(l.T_component_session, 1e-12);
  };
  for (const auto& [session, T] : work.members) {
    if (!is_frozen(session)) continue;
    auto held = held_correction(local(sessions_.frozen().at(session), sessions_.frames()), work.anchor, T);
    auto& now = corrections_[session];
    if (now &&
        std::equal(now->keyframes.begin(), now->keyframes.end(), held.keyframes.begin(), held.keyframes.end(), same))
      continue;
    now = std::make_shared<const Correction>(std::move(held));
    changed_.insert(session);
  }
}

void CorrectedPoses::optimise_component(Work& work) {
  place_groups(work);
  hold_frozen(work);
  std::set<SessionId> active;
  for (const SessionId session : changed_)
    if (work.members.contains(session)) active.insert(session);
  if (active.empty()) return;
  active = work.with_neighbours(active);
  std::erase_if(active, [&](SessionId s) { return is_frozen(s); });
  const Corrections before = corrections_;
  for (;;) {
    const std::set<SessionId> taken_along = solve(work, active, before);
    if (taken_along.empty()) return;
    active.insert(taken_along.begin(), taken_along.end());
  }
}

/// Optimises the active sessions in one graph; the others, including all frozen ones, stay fixed and hold them. Returns
/// those of the others to which a session that moved is connected.
std::set<SessionId> CorrectedPoses::solve(const Work& work, const std::set<SessionId>& active,
                                          const Corrections& before) {
  PoseGraph graph;
  std::map<KeyframeRef, std::size_t> node_of;
  const auto add = [&](const KeyframeRef& k, bool fixed) {
    const auto [node, is_new] = node_of.try_emplace(k, graph.nodes.size());
    if (is_new) graph.nodes.push_back({corrected(k), fixed, raw(k).linear().row(2).transpose()});
    return node->second;
  };
  std::set<const std::vector<PoseConstraint>*> ties;
  for (const SessionId s : active) {
    std::set<std::size_t> asked;
    if (const auto of = work.of.find(s); of != work.of.end())
      for (const auto* edges : of->second) {
        ties.insert(edges);
        for (const PoseConstraint& c : *edges)
          for (const KeyframeRef& k : {c.from, c.to})
            if (k.session == s) asked.insert(k.sequence - 1);
      }
    const Session& session = sessions_.at(s);
    std::optional<std::size_t> last;
    for (const std::size_t i : chain_nodes(session, asked)) {
      const std::size_t node = add({s, i + 1}, s == work.anchor && i == 0);
      if (last) graph.edges.push_back(odometry_edge(session, *last, i, node_of.at({s, *last + 1}), node));
      last = i;
    }
  }
  for (const auto* edges : work.pairs) {  // in the order of the pairs
    if (!ties.contains(edges)) continue;
    for (const PoseConstraint& c : *edges) {
      const std::size_t from = add(c.from, !active.contains(c.from.session));
      graph.edges.push_back({from, add(c.to, !active.contains(c.to.session)), c.T_from_to, c.information, true});
    }
  }
  const PoseGraphResult result = optimise(graph);
  std::map<SessionId, std::shared_ptr<Correction>> found;
  std::set<SessionId> moved_ones;
  for (const auto& [k, node] : node_of) {  // in the order of the sequence
    if (!active.contains(k.session)) continue;
    auto& correction = found[k.session];
    if (!correction) correction = std::make_shared<Correction>(Correction{work.anchor, {}});
    const Pose& T = result.T_graph_node[node];
    correction->keyframes.push_back({k.sequence, orthonormalised(T * raw(k).inverse())});
    const Pose was = before.at(k.session)->corrected(k.sequence, raw(k));
    if ((was.translation() - T.translation()).norm() > moved_m) moved_ones.insert(k.session);
  }
  for (auto& [session, correction] : found) corrections_[session] = std::move(correction);
  std::set<SessionId> taken_along;
  for (const SessionId s : work.with_neighbours(moved_ones))
    if (!active.contains(s) && !is_frozen(s)) taken_along.insert(s);
  return taken_along;
}

void CorrectedPoses::give_out() {
  given_out_.clear();
  const SessionFrames& frames = sessions_.frames();
  for (const auto& [session, correction] : corrections_) {
    auto out = std::make_shared<Correction>(*correction);
    for (CorrectedKeyframe& k : out->keyframes)
      k.T_component_session = frames.given_out(out->component, session, k.T_component_session);
    given_out_[session] = std::move(out);
  }
}

}  // namespace headframe
