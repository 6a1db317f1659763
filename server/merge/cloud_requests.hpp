#pragma once
// Which clouds are asked of the robots, for links are thin: those around the spot where a hypothesis is looked at
// first; while these leave it in doubt, more of the overlap's; and before it is believed those that tell whether the
// mine repeats itself, and where it does what the long-range check needs; of a merge whose sessions have ended, what is
// missing along the overlap.

#include "server/atlas/alignment.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/session_map.hpp"
#include "server/place/hypotheses.hpp"

namespace headframe {

/// Keyframes of a session that lie near another, in the order of the session.
struct NearbyKeyframes {
  std::vector<KeyframePosition> stored;      // whose clouds can speak
  std::vector<KeyframePosition> obtainable;  // whose clouds could
  bool any_let_go = false;                   // some could speak, and made room for others
};

/// A hypothesis with the keyframes that can speak on it.
struct Case {
  Hypothesis hypothesis;
  NearbyKeyframes a, b;
};

struct Candidates {
  std::vector<Case> cases;
  std::size_t awaited = 0;  // that wait for clouds
};

/// The middle of where the two meet, in b's frame.
Eigen::Vector3d middle_of_overlap(const Case& c);

/// Chooses clouds; it keeps nothing. Not thread safe against changes of the sessions.
class CloudRequests {
 public:
  CloudRequests(const MergeConfig& config, const SessionMap& sessions) : config_(config), sessions_(sessions) {}

  Case make_case(SessionId a, SessionId b, const Hypothesis& hypothesis, const CloudSource& clouds) const;

  /// The hypotheses that can be judged now; for the first of the others clouds are asked for.
  Candidates cases_with_clouds(const OrderedPair& pair, const std::vector<Hypothesis>& hypotheses,
                               const Alignment* known, const Attempt& attempt) const;

  /// Of the clouds that can be had, those around the spot where the hypothesis is looked at first.
  std::vector<KeyframeRef> clouds_for_screening(const OrderedPair& pair, const Case& c) const;

  /// Those of the whole overlap, where what a first look showed neither agrees nor contradicts.
  std::vector<KeyframeRef> clouds_for_contact(const OrderedPair& pair, const Case& c) const;

  /// More of those of the overlap, from p_b (in b's frame) on, if they could make the judged placement believed.
  std::vector<KeyframeRef> clouds_for_verdict(const OrderedPair& pair, const Case& c, const Judgement& judged,
                                              const Eigen::Vector3d& p_b) const;

  /// Of a merge of two sessions that have ended: one of each session at every place of the overlap where none is near,
  /// so that it is settled on all of the overlap, as if all clouds were here.
  std::vector<KeyframeRef> clouds_to_settle(const OrderedPair& pair, const Case& c) const;

 private:
  NearbyKeyframes nearby(SessionId id, SessionId other, const Pose& T_id_other, const CloudSource& clouds) const;
  void ask(SessionId id, std::vector<KeyframePosition> obtainable, const Eigen::Vector3d& p, std::size_t most,
           std::vector<KeyframeRef>& wanted) const;

  const MergeConfig config_;
  const SessionMap& sessions_;
};

}  // namespace headframe
