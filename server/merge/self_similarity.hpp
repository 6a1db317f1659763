#pragma once
// Copies within a mine: a session is placed on itself at other places; what fits there for 15 m or more counts as a
// copy.

#include <functional>
#include <optional>
#include <set>

#include "server/merge/screening.hpp"
#include "server/session/self_likeness.hpp"

namespace headframe {

/// Keeps the results of all sessions. Not thread safe.
class SelfSimilarity {
 public:
  SelfSimilarity(const MergeConfig& config, const SessionMap& sessions, HypothesisFinder& finder,
                 SessionSubmaps& submaps, const CloudRequests& requests)
      : judge_(judge_config(config)), sessions_(sessions), finder_(finder), submaps_(submaps), requests_(requests) {}

  /// The session's copies and look-alikes within itself. Searches again when its path or its number of stored clouds
  /// has grown by a quarter, when a complete session has grown at all, when its last cloud has arrived, or when the
  /// requested clouds have arrived or can no longer be obtained.
  const SelfLikeness& of(SessionId id, CloudSource& clouds);
  /// The result of a new search, of which of() does not learn.
  SelfLikeness search(SessionId id, CloudSource& clouds);
  /// Asked before each new search: what search() would find, where that is known from elsewhere.
  void ask_first(std::function<std::optional<SelfLikeness>(SessionId, CloudSource&)> known_elsewhere) {
    known_elsewhere_ = std::move(known_elsewhere);
  }
  /// Whether of() would return at once without searching.
  bool known(SessionId id, const CloudSource& clouds) const;
  /// The last result; a default value for a session that was never searched.
  const SelfLikeness& last(SessionId id) const;

  /// Sets Evidence::repetition and mine_look_alikes, from the results of all sessions so far, and raises
  /// mine_similar_places to what they show. Rates are computed over at least 500 m of path for copies and 200 m for the
  /// others, so short paths count little. The path of a session counts once it was searched and no clouds are wanted
  /// for it.
  void tell_of_mine(Evidence& evidence) const;

  /// Restores results from before a restart; of() returns them while they are still valid.
  void restore(std::map<SessionId, SelfLikeness> known) { known_ = std::move(known); }
  /// The results found since the last call.
  std::map<SessionId, SelfLikeness> take_news() { return std::exchange(news_, {}); }

  void forget(SessionId id) {
    known_.erase(id);
    news_.erase(id);
  }

 private:
  struct OfMine {
    double aliases = 0, look_alikes = 0, similar_places = 0, searched_m = 0;
  };
  OfMine of_mine() const;
  /// The same placement of a session on itself, examined 15 m before and after along its path.
  std::vector<Case> beside(SessionId id, const Hypothesis& hypothesis, const CloudSource& clouds) const;
  /// Which of these placements of a session on itself, other than the identity, are copies at least 15 m long: they
  /// fit at their first place and at one of the places beside it.
  std::set<std::size_t> copies_within(SessionId id, const std::vector<ScreeningResult>& screened, CloudSource& clouds);

  const JudgeConfig judge_;
  const SessionMap& sessions_;
  HypothesisFinder& finder_;
  SessionSubmaps& submaps_;
  const CloudRequests& requests_;
  std::function<std::optional<SelfLikeness>(SessionId, CloudSource&)> known_elsewhere_;
  std::map<SessionId, SelfLikeness> known_, news_;
};

}  // namespace headframe
