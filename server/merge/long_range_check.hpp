#pragma once
// A last look before a placement is accepted, as far as the lidars see: the copy of a tunnel ends somewhere, and rock
// that both saw counts wherever it lies.

#include <set>

#include "server/merge/cloud_requests.hpp"
#include "server/merge/session_submaps.hpp"

namespace headframe {

/// The result of the check.
struct LongRange {
  double violation = 0;          // Evidence::farther_violation ...
  double unexplained = 0;        // ... without what changes of the mine explain
  double rock_in_common = 0;     // Evidence::rock_in_common
  std::set<KeyframeRef> wanted;  // clouds that could add evidence

  void tell(Evidence& e) const;
};

/// Looks for contradictions and for rock in common along the shared path, or where two paths that never meet come
/// nearest, at spots for which all clouds within 25 m of path are stored; with incomplete surroundings distant walls
/// prove nothing, and where no spot has all of them, rock in common is all that is looked for. Looks at all such spots
/// if the mine is known to repeat itself, else at four. Takes some 20 ms for each spot, so it comes last.
///
/// first_b: where the placement was registered first, in b's frame; odometry has drifted since.
LongRange check_long_range(const OrderedPair& pair, const Case& c, const Judgement& judged,
                           const Eigen::Vector3d& first_b, const SessionMap& sessions, SessionSubmaps& submaps,
                           CloudSource& clouds, const JudgeConfig& judge);

}  // namespace headframe
