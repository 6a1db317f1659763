#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <vector>

#include "server/merge/session_map.hpp"

namespace headframe {

/// What the verdict on a pair depends on. While none of it changes, the verdict would not change either. (Where a
/// published alignment is judged again, it also depends on the placement, which each judgement moves a little: once for
/// the same clouds while a session is driven, and once when both have ended, which decides where the merge lies.)
struct JudgedOn {
  std::size_t search = 0;        // Found::version; 0: a published alignment was judged again at its placement
  int looks_like_itself_10 = 0;  // looks_like_itself(), in tenths
  int similar_places_20 = 0;     // Evidence::mine_similar_places, as all sessions show, in twentieths up to a half
  bool copies_known = false;
  int complete = 0;                 // how many of the two sessions are
  std::vector<std::size_t> clouds;  // number of stored clouds, for each case
  bool operator==(const JudgedOn&) const = default;
};

/// For each pair, what its last verdicts were based on. Not thread safe.
class JudgedPairs {
 public:
  /// Whether the pair's last verdict, or where a published alignment is judged again at its placement one of the last
  /// eight, was based on exactly this; remembers it if not. Such an alignment moves a little each time, and which
  /// clouds lie near with it: one that moved back and forth between two placements would be judged again without end.
  bool judged_on(const OrderedPair& pair, const JudgedOn& now) {
    constexpr std::size_t most = 8;
    std::deque<JudgedOn>& before = pairs_[std::minmax(pair.a, pair.b)];
    if (now.search == 0 ? std::find(before.begin(), before.end(), now) != before.end()
                        : !before.empty() && before.front() == now)
      return true;
    before.push_front(now);
    if (before.size() > most) before.pop_back();
    return false;
  }
  void forget(SessionId one, SessionId other) { pairs_.erase(std::minmax(one, other)); }
  void forget(SessionId id) {
    std::erase_if(pairs_, [id](const auto& entry) { return entry.first.first == id || entry.first.second == id; });
  }

 private:
  std::map<std::pair<SessionId, SessionId>, std::deque<JudgedOn>> pairs_;  // by ids in order; the last first
};

}  // namespace headframe
