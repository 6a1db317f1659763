#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "server/merge/session_map.hpp"

namespace headframe {

/// What the verdict on a pair depends on. While none of it changes, the verdict would not change either.
struct JudgedOn {
  std::size_t search = 0;        // Found::version; 0: a published alignment was judged again at its placement
  int asked_overlap_10m = 0;     // overlap demanded because sessions repeat themselves, in tens of metres
  int looks_like_itself_10 = 0;  // looks_like_itself(), in tenths
  bool copies_known = false;
  int complete = 0;                 // how many of the two sessions are
  std::vector<std::size_t> clouds;  // number of stored clouds, for each case
  bool operator==(const JudgedOn&) const = default;
};

/// For each pair, what its last verdict was based on. Not thread safe.
class JudgedPairs {
 public:
  /// Whether the pair's last verdict was based on exactly this; remembers it if not.
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
