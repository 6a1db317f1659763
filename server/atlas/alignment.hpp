#pragma once
// An alignment between two sessions, with the evidence for and against it.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/geometry/se3.hpp"

namespace headframe {

using SessionId = std::int64_t;
using AlignmentId = std::int64_t;

enum class AlignmentState { candidate, verified, published, retracted, rejected };

std::string_view to_string(AlignmentState state);
std::optional<AlignmentState> alignment_state_from(std::string_view name);

/// Everything the verdict was made from. NaN: not measured. evidence_fields() lists the members by name, so that store,
/// API and reports never repeat them.
struct Evidence {
  double probability = 0;      // calibrated, that T_a_b is right
  double pairs = 0;            // keyframe pairs (places) whose registration agrees on T_a_b
  double inlier_fraction = 0;  // of the source points with a partner, the smaller of both directions
  double rmse_m = 0;           // of the inliers
  double overlap_a = 0;        // occupied cells of a's submap met by b's, and the other way round
  double overlap_b = 0;
  double freespace_violation = 0;  // cells of one map that the other's rays pass through / cells checked, both ways
  double weakest_information = 0;  // smallest eigenvalue of the translational information, per inlier (1/m^2)
  double slide_ratio = 0;          // best score after a shift of 3 to 6 m along the weakest axis / score
  double tilt_deg = 0;             // gravity disagreement after registration
  double support = 0;              // score of the hypothesis it came from
  double runner_up = 0;            // probability of the best different hypothesis
};

struct EvidenceField {
  std::string_view name;
  double Evidence::*member;
};
std::span<const EvidenceField> evidence_fields();

/// There is at most one alignment for each pair of sessions; a < b.
struct Alignment {
  AlignmentId id = 0;
  SessionId a = 0;
  SessionId b = 0;
  AlignmentState state = AlignmentState::candidate;
  Pose T_a_b = Pose::Identity();
  Evidence evidence;
};

}  // namespace headframe
