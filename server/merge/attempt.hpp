#pragma once
// The input and the result of one attempt to merge a session.

#include <map>
#include <vector>

#include "server/atlas/decisions.hpp"
#include "server/atlas/frozen.hpp"
#include "server/atlas/pose_constraint.hpp"
#include "server/merge/cloud_source.hpp"
#include "server/place/leads.hpp"
#include "server/session/self_likeness.hpp"
#include "server/support/stage_times.hpp"
#include "server/verification/verification.hpp"

namespace headframe {

/// The placements of one pair that an attempt considered, as T_a_b with a < b: the proposals, best first; those that
/// passed screening, as registered there; and those that were judged.
struct PairTrace {
  SessionId a = 0, b = 0;
  struct Proposal {
    Pose T_a_b;
    ProposalSource source;
  };
  std::vector<Proposal> proposed = {};
  std::vector<Pose> screened = {};
  std::vector<Judgement> judged = {};  // the most probable first
};

/// What one attempt to merge a session did, or one decision of the operator.
struct AttemptReport {
  std::vector<KeyframeRef> wanted;  // clouds to request; call attempt() again once they are here or will not come
  bool unfinished = false;          // there is more to try: call attempt() again soon, after other work
  std::vector<Alignment> changed;   // new or updated alignments, to be stored together with the revision
  bool atlas_changed = false;
  bool provisional_changed = false;     // the provisional placements changed; they have no revision
  std::vector<DecisionRecord> decided;  // new or changed, to be stored with them
  std::vector<PairTrace> traces = {};   // of the pairs that were searched or judged again
  StageTimes times = {};
  std::map<SessionId, SelfLikeness> self_likeness = {};  // found since the last attempt, to be stored
  bool whole = false;                                    // the session was complete: no further keyframe was expected
  SessionId anchored = 0;  // the session that was chosen as its component's anchor, to be stored; 0: none
  std::vector<PairClosures> closures = {};  // for each pair with new ones: all known ones, to be stored
  std::vector<FrozenSession> frozen = {};   // to be stored
  SessionId thawed = 0;                     // a session that is no longer frozen, to be stored; 0: none
};

/// An attempt in progress: the source of its clouds and the report that it fills.
struct Attempt {
  CloudSource& clouds;
  AttemptReport& report;

  void want(const std::vector<KeyframeRef>& more) const {
    report.wanted.insert(report.wanted.end(), more.begin(), more.end());
  }
};

}  // namespace headframe
