#pragma once
// Why two sessions are or are not merged, in words and numbers. Pure: the text depends only on the arguments.

#include <functional>
#include <string>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/atlas/findings.hpp"

namespace headframe {

struct ExplainedSession {
  std::string name;  // "robot/session"
  FamilyId family;   // descriptors of different families or versions are never compared
  double path_m = 0;
  std::uint64_t keyframes = 0;
  std::uint64_t clouds = 0;  // stored
  bool complete = false;     // no keyframe follows
  bool connected = false;
  std::string why_cut = {};    // where its odometry jumped, and what happened to the rest; empty: it did not jump
  std::string why_aside = {};  // why it is set aside; empty: it is not
  bool archived = false;
  std::string site = {};  // the operator's name for the mine it was driven in; empty: there is only one
};

struct Explanation {
  std::string outcome;               // one sentence
  std::vector<Finding> findings;     // of the best hypothesis; empty when nothing fitted
  std::vector<Gate> gates;           // of the same hypothesis
  std::vector<std::string> missing;  // what prevents a merge, and what to do; empty when they are merged
  std::string decision;              // the operator's standing decision; empty without one
};

/// Names of sessions: "robot/session".
using SessionNames = std::function<std::string(SessionId)>;

/// alignment: of the pair a, b; null if none was tried. together: both are in one component.
Explanation explain(const ExplainedSession& a, const ExplainedSession& b, const Alignment* alignment, bool together,
                    const VerdictThresholds& config, const SessionNames& names);

/// For an alignment that was published and no longer is.
std::string why_withdrawn(const Alignment& now);

}  // namespace headframe
