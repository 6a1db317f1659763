#pragma once
// Which of the sessions that PartnerRanking names are worth an attempt? Their walls and descriptors tell, without
// clouds, in some 15 ms a pair.

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "server/merge/session_map.hpp"
#include "server/place/hypotheses.hpp"

namespace headframe {

/// Remembers what it found until one of the two sessions has grown. Not thread safe.
class PartnerPromise {
 public:
  PartnerPromise(const MergeConfig& config, const SessionMap& sessions, HypothesisFinder& finder)
      : config_(config), sessions_(sessions), finder_(finder) {}

  /// Orders the first sessions in `ranked` that could merge with this one (twice MergeConfig::partners) by their
  /// promise (HypothesisFinder::promise) and their rank, without those that promise next to nothing. Sessions of other
  /// descriptor families are compared among themselves, and come last. Searches a few pairs; nothing if more are left
  /// to search, which the next call goes on with.
  std::optional<std::vector<SessionId>> choose(SessionId id, const std::vector<SessionId>& ranked);

  void forget(SessionId id) {
    std::erase_if(known_, [&](const auto& k) { return k.first.first == id || k.first.second == id; });
  }

 private:
  struct Known {
    double promise = 0, first_path_m = 0, second_path_m = 0;  // paths when it was searched, by id
  };
  bool is_known(SessionId id, SessionId other) const;
  void search(SessionId id, const std::vector<SessionId>& others);
  void append_promising(SessionId id, const std::vector<SessionId>& compared, std::vector<SessionId>& out) const;

  const MergeConfig config_;
  const SessionMap& sessions_;
  HypothesisFinder& finder_;
  std::map<std::pair<SessionId, SessionId>, Known> known_;
};

}  // namespace headframe
