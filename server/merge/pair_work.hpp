#pragma once
// An attempt's searches, shared with other servers that have time for them.

#include <deque>
#include <map>
#include <set>

#include "server/merge/pair_search.hpp"

namespace headframe {

/// Announces what an attempt will search, takes what others found, and searches ahead while others are busy with what
/// is needed next. What it returns is what a search here would find, to the bit: results are known by the digest of all
/// that they depend on. Without helpers it does nothing. Not thread safe.
class PairWork {
 public:
  PairWork(PairSearch& search, const SessionMap& sessions, PairHelpers* helpers)
      : search_(search), sessions_(sessions), helpers_(helpers) {}

  /// An attempt, during which neither sessions nor clouds change. Only then anything is announced and taken.
  class During {
   public:
    explicit During(PairWork& work) : work_(work) { work_.begin(); }
    ~During() { work_.digests_.reset(); }
    During(const During&) = delete;
    During& operator=(const During&) = delete;

   private:
    PairWork& work_;
  };

  /// Whether others have come since the last call, during this attempt: it is time to announce what is needed.
  bool helpers_came();
  /// No more will be searched. `unfinished`: the attempt goes on later, and what was announced for it may be worked on
  /// meanwhile.
  void end(bool unfinished);
  /// These will be needed in this order, and afterwards, by the attempts of other sessions, those of `later`; a == b:
  /// how a session looks like itself.
  void announce(const std::vector<OrderedPair>& pairs, const std::vector<OrderedPair>& later,
                const CloudSource& clouds);

  /// What another server, or this one ahead of time, has found. Nullopt: it has to be found now, and nobody else will.
  std::optional<PairFindings> findings(const OrderedPair& pair, CloudSource& clouds);

 private:
  /// nullopt: helpers can not know all that the result depends on.
  std::optional<PairTask> task_of(const OrderedPair& pair, const CloudSource& clouds);
  const std::string& digest(SessionId id, const CloudSource& clouds);
  std::optional<PairFindings> kept(const std::string& digest);
  bool search_one_ahead(CloudSource& clouds);
  void begin();

  static constexpr std::size_t most_kept = 64, most_open = 1024;

  PairSearch& search_;
  const SessionMap& sessions_;
  PairHelpers* const helpers_;
  bool helped_ = false;
  std::optional<std::map<SessionId, std::string>> digests_;  // during this attempt; nullopt: there is none
  std::vector<PairTask> announced_;                          // for this attempt
  std::set<std::string> open_;                               // digests of what was announced and not asked for yet
  std::map<std::string, PairFindings> ahead_;
  std::deque<std::string> order_ahead_;  // oldest first
};

}  // namespace headframe
