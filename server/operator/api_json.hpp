#pragma once
// The JSON of the operator's API, as text. Numbers that are not finite become null. All functions are pure.

#include <string>
#include <string_view>
#include <vector>

#include "server/atlas/explain.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// The outcome of "?wait=": what was still pending when the answer was made, and whether the time ran out.
struct WaitOutcome {
  Pending pending;
  bool waited_out = false;
};

/// 16 numbers, row-major.
std::vector<double> row_major(const Pose& T);

std::string error_json(const Error& error);
std::string status_json(const std::vector<SessionRow>& sessions, const AtlasView& view, const Pending& pending,
                        const LinkHealth& links, double uptime_s);
std::string sessions_json(const std::vector<SessionRow>& sessions, const Atlas& atlas);

/// Of pairs that the evidence alone rejected, only the number is given: a database of several years has many of them.
/// `sessions` gives the names of the ids in the atlas; `wait` may be null.
std::string atlas_json(const AtlasView& view, const std::vector<SessionRow>& sessions, const WaitOutcome* wait);

/// Selects the alignments of an answer.
struct AlignmentChoice {
  std::optional<AlignmentState> state;  // only those in this state
  std::optional<AlignmentId> id;        // only this one
  std::size_t most_rejected = 0;        // at most so many that the evidence alone rejected, the newest ones
};

/// Includes the revision, and how many alignments were left out because of most_rejected.
std::string alignments_json(const AtlasView& view, const AlignmentChoice& choice);
/// One alignment; the JSON of an error if there is none with this id.
std::string alignment_json(const AtlasView& view, AlignmentId id);

/// `alignment` is null if the pair has not been tried yet.
std::string explanation_json(const SessionRow& a, const SessionRow& b, const AlignmentRow* alignment,
                             const Explanation& explanation, const Atlas& atlas);

/// One session, in the form that sessions_json uses.
std::string session_json(const SessionRow& row, const Atlas& atlas);
/// The result of choosing an anchor: the revision, and the component that now contains the session.
std::string anchor_json(const Atlas& atlas, SessionId session);

// Events (event_diff.hpp): one JSON object each, which begins with "type".
std::string session_event(std::string_view type, const SessionRow& row);
std::string alignment_event(const AlignmentRow& row);
std::string revision_event(const Atlas& atlas);
std::string pending_event(const Pending& pending);

}  // namespace headframe
