#include "server/atlas/rivals.hpp"

#include <algorithm>

namespace headframe {
namespace {

bool in_question(const Alignment& k, double look_alikes) {
  const bool merges = k.state == AlignmentState::verified || k.state == AlignmentState::published;
  return merges && k.ruling == Ruling::none && k.evidence.similar_places >= look_alikes;
}

/// Whether the candidate is good enough to be taken for the right one of the two.
bool rivals(const Alignment& candidate, const Alignment& k, const VerdictThresholds& thresholds) {
  return candidate.state == AlignmentState::candidate && candidate.ruling == Ruling::none && has_placement(candidate) &&
         odds(candidate.evidence.probability) >= thresholds.runner_up_share * odds(k.evidence.probability) &&
         k.evidence.overlap_m < clearly_longer * candidate.evidence.overlap_m;
}

SessionId other_than(SessionId shared, const Alignment& k) { return k.a == shared ? k.b : k.a; }

Pose T_shared_other(SessionId shared, const Alignment& k) { return k.a == shared ? k.T_a_b : Pose(k.T_a_b.inverse()); }

}  // namespace

Doubts rivalled(std::span<const Alignment> alignments, const VerdictThresholds& thresholds, double look_alikes,
                const std::set<SessionId>& present, const Contacts& contacts) {
  Doubts doubts;
  if (!contacts) return doubts;
  for (std::size_t i = 0; i < alignments.size(); ++i) {
    const Alignment& k = alignments[i];
    if (!in_question(k, look_alikes)) continue;
    for (const Alignment& candidate : alignments) {
      if (!rivals(candidate, k, thresholds) || !present.contains(candidate.a) || !present.contains(candidate.b))
        continue;
      for (const SessionId shared : {k.a, k.b}) {
        if (shared != candidate.a && shared != candidate.b) continue;
        const SessionId one = other_than(shared, k), other = other_than(shared, candidate);
        const Pose T_one_other = T_shared_other(shared, k).inverse() * T_shared_other(shared, candidate);
        const auto pair = std::minmax(one, other);
        const Contact contact = contacts(pair.first, pair.second, one < other ? T_one_other : T_one_other.inverse());
        if (contact == Contact::contradicts) doubts.insert_or_assign(i, pair);
        if (contact == Contact::unknown && k.state == AlignmentState::verified) doubts.try_emplace(i, std::nullopt);
      }
    }
  }
  return doubts;
}

}  // namespace headframe
