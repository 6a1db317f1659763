#pragma once
// What one attempt to merge a session works with, and what it did.

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

/// The placements of one pair that an attempt looked at, as T_a_b with a < b: what the proposals were, best first, and
/// where a first registration put those that screening left.
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
  bool provisional_changed = false;     // which robots may be told that ask for it; no revision
  std::vector<DecisionRecord> decided;  // new or changed, to be stored with them
  std::vector<PairTrace> traces = {};   // of the pairs that were searched or judged anew
  StageTimes times = {};
  std::map<SessionId, SelfLikeness> self_likeness = {};  // found since the last attempt, to be stored
  bool whole = false;                                    // the session was complete: no keyframe was expected
  SessionId anchored = 0;  // the session that was chosen as its component's anchor, to be stored; 0: none
  std::vector<PairClosures> closures = {};  // all that are known of the pairs for which more were found, to be stored
  std::vector<FrozenSession> frozen = {};   // to be stored
  SessionId thawed = 0;                     // frozen no more, to be stored; 0: none
};

/// An attempt under way: where its clouds come from, and the report that it fills.
struct Attempt {
  CloudSource& clouds;
  AttemptReport& report;

  void want(const std::vector<KeyframeRef>& more) const {
    report.wanted.insert(report.wanted.end(), more.begin(), more.end());
  }
};

}  // namespace headframe
