#pragma once
// Which clouds are requested from the robots; few, because links are slow. First those around the spot where a
// hypothesis is screened; while it is in doubt, more of the overlap; before it is accepted, those that show whether the
// mine repeats itself and, if it does, those that the long-range check needs. After both sessions of a merge have
// ended, those that are missing along the overlap.

#include "server/atlas/alignment.hpp"
#include "server/merge/attempt.hpp"
#include "server/merge/session_map.hpp"
#include "server/place/hypotheses.hpp"

namespace headframe {

/// Keyframes of a session that lie near the other session, in the order of the session.
struct NearbyKeyframes {
  std::vector<KeyframePosition> stored;      // their clouds are stored
  std::vector<KeyframePosition> obtainable;  // their clouds can be requested
  bool any_let_go = false;                   // some clouds were deleted to make room for others
};

/// A hypothesis with the keyframes whose clouds can support or contradict it.
struct Case {
  Hypothesis hypothesis;
  NearbyKeyframes a, b;
};

struct Candidates {
  std::vector<Case> cases;
  std::size_t awaited = 0;  // cases that wait for clouds
};

/// The middle of the overlap, in b's frame.
Eigen::Vector3d middle_of_overlap(const Case& c);

/// Chooses clouds. Stateless. The sessions must not change during a call.
class CloudRequests {
 public:
  CloudRequests(const MergeConfig& config, const SessionMap& sessions) : config_(config), sessions_(sessions) {}

  Case make_case(SessionId a, SessionId b, const Hypothesis& hypothesis, const CloudSource& clouds) const;

  /// The hypotheses that can be judged now. Clouds are requested for the best of the others, which have to wait.
  Candidates cases_with_clouds(const OrderedPair& pair, const std::vector<Hypothesis>& hypotheses,
                               const Alignment* known, const Attempt& attempt) const;

  /// Obtainable clouds around the spot where the hypothesis is screened.
  std::vector<KeyframeRef> clouds_for_screening(const OrderedPair& pair, const Case& c) const;

  /// The same for one further place of the overlap, for when the first said nothing.
  std::vector<KeyframeRef> clouds_for_further_screening(const OrderedPair& pair, const Case& c) const;

  /// Clouds of the whole overlap, for when a first look found neither agreement nor contradiction.
  std::vector<KeyframeRef> clouds_for_contact(const OrderedPair& pair, const Case& c) const;

  /// More clouds of the overlap, those nearest to p_b (in b's frame) first, if they could make the placement
  /// acceptable.
  std::vector<KeyframeRef> clouds_for_verdict(const OrderedPair& pair, const Case& c, const Judgement& judged,
                                              const Eigen::Vector3d& p_b) const;

  /// For a merge of two sessions that have ended: one cloud of each session at every place of the overlap that has none
  /// nearby, so that the verdict covers the whole overlap as if all clouds were stored. If the sessions drifted, so
  /// that their places differ (Evidence::spread_m), all clouds of the overlap.
  std::vector<KeyframeRef> clouds_to_settle(const OrderedPair& pair, const Case& c, double spread_m) const;

 private:
  NearbyKeyframes nearby(SessionId id, SessionId other, const Pose& T_id_other, const CloudSource& clouds) const;
  void ask_around(SessionId id, const NearbyKeyframes& nearby, std::size_t keyframe, double reach_m,
                  std::vector<KeyframeRef>& wanted) const;
  void ask(SessionId id, std::vector<KeyframePosition> obtainable, const Eigen::Vector3d& p, std::size_t most,
           std::vector<KeyframeRef>& wanted) const;

  const MergeConfig config_;
  const SessionMap& sessions_;
};

}  // namespace headframe
