#include "server/atlas/merge_graph.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace headframe {
namespace {

using Pair = std::pair<SessionId, SessionId>;  // first < second

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

  /// Transform of b's component in that of a.
  Pose joining(const Alignment& alignment) {
    return components[component_of[alignment.a]][alignment.a] * alignment.T_a_b *
           components[component_of[alignment.b]][alignment.b].inverse();
  }

  /// What the sessions of both components say about it, except those with an alignment of their own.
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

/// For each alignment: the number of triangles of usable alignments that it closes, minus those that it does not close.
/// A wrong alignment fails with every third session that both know, a right one only with those that a wrong one
/// affects.
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

/// Indices of the usable alignments, the strongest first.
std::vector<std::size_t> by_strength(std::span<const Alignment> alignments, const LoopTolerance& tolerance) {
  const std::vector<int> votes = triangle_votes(alignments, tolerance);
  std::vector<std::size_t> order;
  order.reserve(alignments.size());
  for (std::size_t i = 0; i < alignments.size(); ++i)
    if (usable(alignments[i])) order.push_back(i);
  const auto rank = [&](std::size_t i) {
    const Alignment& k = alignments[i];
    // Two placements of one piece of a session share its aliases, which therefore do not tell which one is right.
    const double p = std::min(std::max(k.evidence.probability, k.evidence.probability_if_unique), 1 - 1e-9);
    const double sure =
        p / (1 - p) * (1 - k.evidence.runner_up);  // odds: a runner-up of .01 weighs less than an overlap
    return std::tuple(k.ruling != Ruling::confirmed, -votes[i], -sure, -k.evidence.seen_points, k.a, k.b);
  };
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return rank(i) < rank(j); });
  return order;
}

/// The one chosen last, else the earliest; of frozen sessions only, if there are any.
Frames::const_iterator anchor_of(const Frames& frames, std::span<const SessionId> anchors,
                                 const FrozenSessions& frozen) {
  const auto first_frozen =
      std::find_if(frames.begin(), frames.end(), [&](const auto& entry) { return frozen.contains(entry.first); });
  const bool any_frozen = first_frozen != frames.end();
  const auto chosen = std::find_if(anchors.rbegin(), anchors.rend(), [&](SessionId id) {
    return frames.contains(id) && (!any_frozen || frozen.contains(id));
  });
  if (chosen != anchors.rend()) return frames.find(*chosen);
  return any_frozen ? first_frozen : frames.begin();
}

Component component_from(const Frames& frames, std::span<const SessionId> anchors, const FrozenSessions& frozen) {
  const auto anchor = anchor_of(frames, anchors, frozen);
  Component component;
  component.id = anchor->first;
  const Pose T_component = anchor->second.inverse();
  for (const auto& [session, T] : frames)
    component.placements.push_back(
        {session, session == component.id ? Pose::Identity() : orthonormalised(T_component * T)});
  return component;
}

/// Takes the usable alignments one after another. Those in doubt come last and are only checked, not taken, so that
/// what contradicts them keeps doing so.
class Merging {
 public:
  /// Adds to the doubts; if it added some, everything has to be repeated.
  Merging(std::span<const SessionId> sessions, std::span<const Alignment> alignments, const LoopTolerance& tolerance,
          const Contacts& contacts, Doubts& doubts)
      : alignments_(alignments), contacts_(contacts), doubts_(doubts), growing_(sessions) {
    for (const Alignment& alignment : alignments) result_.states.push_back(alignment.state);
    result_.contradicted_by.resize(alignments.size());
    for (const Alignment& alignment : alignments)
      if (usable(alignment)) aligned_.emplace(alignment.a, alignment.b);
    std::vector<std::size_t> order = by_strength(alignments, tolerance);
    std::stable_partition(order.begin(), order.end(), [&](std::size_t i) { return !doubts.contains(i); });
    for (const std::size_t i : order) take(i, tolerance);
  }

  MergeResult result(std::span<const SessionId> anchors, const FrozenSessions& frozen, const Meetings& meet) {
    for (Frames& frames : growing_.components) {
      if (frames.empty()) continue;
      std::vector<Alignment> edges;
      for (const Alignment& alignment : published_)
        if (frames.contains(alignment.a)) edges.push_back(alignment);
      const bool loops = edges.size() >= frames.size();
      if (loops || !frozen_together(frames, frozen).empty()) relax(frames, edges, frozen, meet);
      result_.components.push_back(component_from(frames, anchors, frozen));
    }
    std::sort(result_.components.begin(), result_.components.end(),
              [](const auto& x, const auto& y) { return x.id < y.id; });
    return result_;
  }

 private:
  void take(std::size_t i, const LoopTolerance& tolerance) {
    const Alignment& alignment = alignments_[i];
    const bool loop = growing_.component_of.at(alignment.a) == growing_.component_of.at(alignment.b);
    if (loop ? agrees(growing_.T_a_b(alignment), alignment.T_a_b, tolerance) : may_join(i)) {
      if (!loop) {
        growing_.join(alignment);
        joined_.push_back(i);
      }
      result_.states[i] = AlignmentState::published;
      published_.push_back(alignment);
      return;
    }
    // A confirmed one waits and comes back when what it contradicts is retracted. So does one in doubt.
    const bool waits =
        alignment.ruling == Ruling::confirmed || alignment.state != AlignmentState::published || doubts_.contains(i);
    result_.states[i] = waits ? AlignmentState::verified : AlignmentState::retracted;
  }

  bool may_join(std::size_t i) {
    const Alignment& alignment = alignments_[i];
    if (!contacts_ || alignment.ruling == Ruling::confirmed) return true;
    const Growing::Met met = growing_.met(alignment, aligned_, contacts_);
    if (met.contact == Contact::contradicts) {
      result_.contradicted_by[i] = met.by;
      doubt_between(i, met.by);
    }
    if (const auto doubt = doubts_.find(i); doubt != doubts_.end()) {
      result_.contradicted_by[i] = doubt->second;
      return false;
    }
    const bool waits = met.contact == Contact::unknown && alignment.state != AlignmentState::published;
    return met.contact != Contact::contradicts && !waits;
  }

  /// Of the alignments that bring the two contradicting sessions together, one is wrong: a copy as long as the overlap
  /// that it was found on. Only those with a clearly longer overlap are trusted.
  void doubt_between(std::size_t i, const Pair& by) {
    const std::vector<std::size_t> way = way_between(i, by);
    const double shared_m = alignments_[i].evidence.overlap_m;
    bool equals = false;
    for (const std::size_t k : way) {
      const double other_m = alignments_[k].evidence.overlap_m;
      if (k == i || alignments_[k].ruling == Ruling::confirmed || other_m >= clearly_longer * shared_m) continue;
      doubts_.emplace(k, by);
      equals |= shared_m < clearly_longer * other_m;
    }
    if (equals) doubts_.emplace(i, by);
  }

  /// Alignment i, and those already joined that connect its two sessions.
  std::vector<std::size_t> way_between(std::size_t i, const Pair& by) const {
    std::map<SessionId, std::size_t> came_by;  // the alignment over which each was reached, starting from the first
    std::vector<SessionId> reached{by.first};
    std::vector<std::size_t> edges = joined_;
    edges.push_back(i);
    for (std::size_t at = 0; at < reached.size(); ++at)
      for (const std::size_t k : edges) {
        const auto [a, b] = std::pair(alignments_[k].a, alignments_[k].b);
        if (reached[at] != a && reached[at] != b) continue;
        const SessionId next = reached[at] == a ? b : a;
        if (next == by.first || !came_by.emplace(next, k).second) continue;
        reached.push_back(next);
      }
    std::vector<std::size_t> way;
    for (SessionId at = by.second; at != by.first;) {
      way.push_back(came_by.at(at));
      at = alignments_[way.back()].a == at ? alignments_[way.back()].b : alignments_[way.back()].a;
    }
    return way;
  }

  std::span<const Alignment> alignments_;
  const Contacts& contacts_;
  Doubts& doubts_;
  Growing growing_;
  std::set<Pair> aligned_;
  std::vector<std::size_t> joined_;
  std::vector<Alignment> published_;
  MergeResult result_;
};

}  // namespace

bool agrees(const Pose& T_loop, const Pose& T, const LoopTolerance& tolerance) {
  const Pose error = T_loop.inverse() * T;
  return rotation_angle_rad(error) < tolerance.rotation_rad &&
         error.translation().norm() < tolerance.translation_m + 0.01 * T.translation().norm();
}

MergeResult merge_sessions(std::span<const SessionId> sessions, std::span<const Alignment> alignments,
                           const LoopTolerance& tolerance, std::span<const SessionId> anchors, const Contacts& contacts,
                           const FrozenSessions& frozen, const Meetings& meet, Doubts doubts) {
  for (;;) {
    const std::size_t before = doubts.size();
    Merging merging(sessions, alignments, tolerance, contacts, doubts);
    if (doubts.size() == before) return merging.result(anchors, frozen, meet);
  }
}

}  // namespace headframe
