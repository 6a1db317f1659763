#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "server/merge/session_map.hpp"

namespace headframe {

/// What a pair was judged on. While nothing of it changes, the verdict would not either.
struct JudgedOn {
  std::size_t search = 0;        // Found::version; 0: a published alignment was judged again where it lies
  int asked_overlap_10m = 0;     // that the repetition of all sessions asks for, in tens of metres
  int looks_like_itself_10 = 0;  // looks_like_itself(), in tenths
  bool copies_known = false;
  int complete = 0;                 // of the two sessions
  std::vector<std::size_t> clouds;  // that were stored, for each case
  bool operator==(const JudgedOn&) const = default;
};

/// The last verdict's grounds of each pair. Not thread safe.
class JudgedPairs {
 public:
  /// Whether the pair was judged on just this; remembers it if not.
  bool judged_on(const OrderedPair& pair, const JudgedOn& now) {
    JudgedOn& before = pairs_[std::minmax(pair.a, pair.b)];
    if (before == now) return true;
    before = now;
    return false;
  }
  void forget(SessionId one, SessionId other) { pairs_.erase(std::minmax(one, other)); }
  void forget(SessionId id) {
    std::erase_if(pairs_, [id](const auto& entry) { return entry.first.first == id || entry.first.second == id; });
  }

 private:
  std::map<std::pair<SessionId, SessionId>, JudgedOn> pairs_;  // by ids in order
};

}  // namespace headframe
