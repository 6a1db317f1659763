#pragma once
// Searches pairs of drawn drives apart from any pipeline, as another server would.

#include "server/merge/pair_search.hpp"
#include "tests/scenario/drawn_base.hpp"

namespace headframe::test {

/// With these drives as sessions 1, 2, ... of which each has ended.
struct PairSearcher {
  explicit PairSearcher(const std::vector<Drive>& drives, const MergeConfig& with = waits_for_no_others())
      : config(with) {
    for (const Drive& drive : drives) {
      const SessionId id = ++sessions_count;
      sessions.add(id, ScanContext().id());
      for (std::size_t k = 0; k < drive.keyframes.size(); ++k) {
        sessions.add_keyframe(id, drive.keyframes[k]);
        shelf.clouds[{id, k + 1}] = drive.clouds[k];
      }
      sessions.complete(id);
    }
  }

  std::string digest(SessionId a, SessionId b) const { return search.digest(a, shelf) + search.digest(b, shelf); }
  std::string find(SessionId a, SessionId b) { return encode_findings(search.find(a, b, shelf)); }
  PairTask task(SessionId a, SessionId b) const {
    return {a, b, sessions.at(a).keyframes.size(), sessions.at(b).keyframes.size(), true, true, digest(a, b)};
  }

  const MergeConfig config;
  SessionId sessions_count = 0;
  Shelf shelf;
  SessionMap sessions{config};
  HypothesisFinder finder{finder_config(config)};
  SessionSubmaps submaps{config, sessions};
  CloudRequests requests{config, sessions};
  SelfSimilarity self{config, sessions, finder, submaps, requests};
  CandidateVerifier verifier{config, sessions, submaps, self, requests};
  PairSearch search{config, sessions, finder, submaps, requests, self, verifier};
};

}  // namespace headframe::test
