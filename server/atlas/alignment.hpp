#pragma once
// An alignment between two sessions, with the evidence for and against it.

#include <optional>
#include <string_view>
#include <vector>

#include "common/geometry/se3.hpp"
#include "server/session/ids.hpp"
#include "server/verification/change.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// provisional: all that is there convinces, and a robot that still drives may yet come to see that it is a look-alike.
enum class AlignmentState { candidate, provisional, verified, published, retracted, rejected };

std::string_view to_string(AlignmentState state);
std::optional<AlignmentState> alignment_state_from(std::string_view name);

/// What the operator's latest standing decision says of the placement T_a_b (server/atlas/decisions.hpp).
/// placed: by hand, and nothing was said of it since.
enum class Ruling { none, confirmed, refused, retracted, placed };

std::string_view to_string(Ruling ruling);

/// Two sessions that an alignment would bring together, and that contradict each other there.
struct Objection {
  SessionId a = 0, b = 0;
  double violation = 0;  // share of the points of one that the other's rays pass through, where that is most
};

/// There is at most one alignment for each pair of sessions; a < b.
struct Alignment {
  AlignmentId id = 0;
  SessionId a = 0;
  SessionId b = 0;
  AlignmentState state = AlignmentState::candidate;
  Pose T_a_b = Pose::Identity();
  Evidence evidence;
  AlignmentState verdict = AlignmentState::candidate;  // up to verified, or rejected: what the evidence alone says
  Ruling ruling = Ruling::none;
  std::optional<Pose> T_a_b_runner_up = std::nullopt;  // what evidence.runner_up speaks of; none: there was none
  std::optional<Objection> objection = std::nullopt;   // what holds it back; not stored: found anew after a restart
  std::vector<Change> changes = {};                    // of the mine between the two, in a's frame
};

/// False: nothing could be registered, T_a_b means nothing.
inline bool has_placement(const Alignment& alignment) { return alignment.evidence.inlier_fraction > 0; }

}  // namespace headframe
