#pragma once
// Why two sessions are or are not merged, in words and figures. Pure: the text follows from what is passed in.

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
  std::string why_cut = {};    // where its odometry jumped, and what became of the rest; empty: it did not
  std::string why_aside = {};  // it is set aside, and why; empty: it is not
  bool archived = false;
  std::string site = {};  // the mine it was driven in, by the operator's name; empty: he has one alone
};

struct Explanation {
  std::string outcome;               // one sentence
  std::vector<Finding> findings;     // of the best hypothesis; empty when nothing fitted
  std::vector<Gate> gates;           // of it
  std::vector<std::string> missing;  // what keeps them apart, and what to do; empty when they are merged
  std::string decision;              // the operator's standing word; empty without one
};

/// Sessions by their names: "robot/session".
using SessionNames = std::function<std::string(SessionId)>;

/// alignment: of the pair a, b; null when nothing has been tried. together: both are in one component.
Explanation explain(const ExplainedSession& a, const ExplainedSession& b, const Alignment* alignment, bool together,
                    const VerdictThresholds& config, const SessionNames& names);

/// Of an alignment that was published and is not any more.
std::string why_withdrawn(const Alignment& now);

}  // namespace headframe
