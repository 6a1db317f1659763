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

/// provisional: all present evidence is convincing, but a robot that still drives may yet show that it is a look-alike.
enum class AlignmentState { candidate, provisional, verified, published, retracted, rejected };

std::string_view to_string(AlignmentState state);
std::optional<AlignmentState> alignment_state_from(std::string_view name);

/// What the operator's latest standing decision says about the placement T_a_b (server/atlas/decisions.hpp). placed:
/// placed by hand, and nothing was decided since.
enum class Ruling { none, confirmed, refused, retracted, placed };

std::string_view to_string(Ruling ruling);

/// Two sessions that an alignment would bring together and that contradict each other there.
struct Objection {
  SessionId a = 0, b = 0;
  double violation = 0;  // greatest share of the points of one session that the other's rays pass through
};

/// There is at most one alignment for each pair of sessions; a < b.
struct Alignment {
  AlignmentId id = 0;
  SessionId a = 0;
  SessionId b = 0;
  AlignmentState state = AlignmentState::candidate;
  Pose T_a_b = Pose::Identity();
  Evidence evidence;
  AlignmentState verdict = AlignmentState::candidate;  // what the evidence alone says: at most verified
  Ruling ruling = Ruling::none;
  std::optional<Pose> T_a_b_runner_up = std::nullopt;  // the placement of evidence.runner_up; nullopt: none
  std::optional<Objection> objection = std::nullopt;  // what holds it back; not stored, but found again after a restart
  std::vector<Change> changes = {};                   // of the mine between the two sessions, in a's frame
};

/// False if nothing could be registered: then T_a_b has no meaning.
inline bool has_placement(const Alignment& alignment) { return alignment.evidence.inlier_fraction > 0; }

}  // namespace headframe
