#pragma once
// Copies that a mine shows of itself: a session is laid on itself elsewhere, and what fits there for 15 m and more
// counts.

#include "server/merge/screening.hpp"
#include "server/session/self_likeness.hpp"

namespace headframe {

/// Owns what is known of it. Not thread safe.
class SelfSimilarity {
 public:
  SelfSimilarity(const MergeConfig& config, const SessionMap& sessions, HypothesisFinder& finder,
                 SessionSubmaps& submaps, const CloudRequests& requests)
      : judge_(judge_config(config)), sessions_(sessions), finder_(finder), submaps_(submaps), requests_(requests) {}

  /// Looks for copies again when the session, or what is stored of its clouds, has grown by a quarter.
  const SelfLikeness& of(SessionId id, CloudSource& clouds);
  /// False: of() would look.
  bool known(SessionId id, const CloudSource& clouds) const;
  /// What was found last; nothing of a session that nobody asked about.
  const SelfLikeness& last(SessionId id) const;

  /// Sets what all sessions show of themselves so far: Evidence::repetition and mine_look_alikes. Of less than 500 m
  /// of path little can be said of copies, of less than 200 m of look-alikes, and of sessions that have yet to be
  /// looked at nothing.
  void tell_of_mine(Evidence& evidence) const;

  /// What was found before a restart; of() looks no further while it still holds.
  void restore(std::map<SessionId, SelfLikeness> known) { known_ = std::move(known); }
  /// What was found since it was taken last.
  std::map<SessionId, SelfLikeness> take_news() { return std::exchange(news_, {}); }

  void forget(SessionId id) {
    known_.erase(id);
    news_.erase(id);
  }

 private:
  /// At least so much path is taken to be known.
  double per_100_m(double SelfLikeness::*counted, double least_m) const;
  /// The same placement of a session on itself, looked at 15 m before and behind along its path.
  std::vector<Case> beside(SessionId id, const Hypothesis& hypothesis, const CloudSource& clouds) const;
  /// How many of these placements of a session on itself, other than where it lies, are copies 15 m long and more:
  /// their first place looks right by itself, and so does one of those beside it.
  int copies_within(SessionId id, const std::vector<ScreeningResult>& screened, CloudSource& clouds);

  const JudgeConfig judge_;
  const SessionMap& sessions_;
  HypothesisFinder& finder_;
  SessionSubmaps& submaps_;
  const CloudRequests& requests_;
  std::map<SessionId, SelfLikeness> known_, news_;
};

}  // namespace headframe
