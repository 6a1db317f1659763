#include "server/merge/ordered_pair.hpp"

#include <utility>

namespace headframe {

Pose by_ids(const OrderedPair& pair, const Pose& T) { return pair.a < pair.b ? T : T.inverse(); }

Judgement by_ids(const OrderedPair& pair, Judgement judgement) {
  if (pair.a < pair.b) return judgement;
  for (Change& change : judgement.changes) change = seen_from_b(change, judgement.T_a_b);
  judgement.T_a_b = judgement.T_a_b.inverse();
  std::swap(judgement.evidence.overlap_a, judgement.evidence.overlap_b);
  return judgement;
}

}  // namespace headframe
