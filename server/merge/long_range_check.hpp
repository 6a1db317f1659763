#pragma once
// A placement that is about to be believed is looked at once more, as far as the lidars see: copies end somewhere.

#include <set>

#include "server/merge/cloud_requests.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// What a look farther off found.
struct LongRange {
  double violation = 0;          // Evidence::farther_violation ...
  double unexplained = 0;        // ... without what changes of the mine explain
  std::set<KeyframeRef> wanted;  // clouds that could tell more
};

/// Looks along the path that both share, at spots all of whose clouds within 25 m are stored: of what is half known,
/// far walls say nothing. Everywhere where the mine is known to repeat itself, else at four spots. Takes some 20 ms for
/// each spot, so it is asked last.
LongRange check_long_range(const OrderedPair& pair, const Case& c, const Judgement& judged, const SessionMap& sessions,
                           SessionSubmaps& submaps, CloudSource& clouds, const JudgeConfig& judge);

}  // namespace headframe
