#pragma once
// The JSON of the operator's API, as text. Numbers that are not finite become null. Pure.

#include <string>
#include <string_view>
#include <vector>

#include "server/atlas/explain.hpp"
#include "server/station/station.hpp"

namespace headframe {

/// What came of "?wait=": what was still pending when the answer was made, and whether time ran out.
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

/// Transforms are 16 numbers, row-major. Of pairs that were rejected by the evidence alone it says only how many there
/// are: in a database of some years there are many. `sessions` gives the names of the ids in the atlas; `wait` may be
/// null.
std::string atlas_json(const AtlasView& view, const std::vector<SessionRow>& sessions, const WaitOutcome* wait);

/// Which alignments an answer has.
struct AlignmentChoice {
  std::optional<AlignmentState> state;  // those in this state alone
  std::optional<AlignmentId> id;        // this one alone
  std::size_t most_rejected = 0;        // of those that were rejected by the evidence alone, the newest
};

/// With the revision they are of, and how many were left out for most_rejected.
std::string alignments_json(const AtlasView& view, const AlignmentChoice& choice);
/// One of them; an error's JSON when it is not there.
std::string alignment_json(const AtlasView& view, AlignmentId id);

/// alignment may be null: nothing has been tried.
std::string explanation_json(const SessionRow& a, const SessionRow& b, const AlignmentRow* alignment,
                             const Explanation& explanation, const Atlas& atlas);

/// One session, as sessions_json has it.
std::string session_json(const SessionRow& row, const Atlas& atlas);
/// What became of a choice of anchor: the revision, and the component that the session is in now.
std::string anchor_json(const Atlas& atlas, SessionId session);

// Events (event_diff.hpp), one JSON object each, "type" first.
std::string session_event(std::string_view type, const SessionRow& row);
std::string alignment_event(const AlignmentRow& row);
std::string revision_event(const Atlas& atlas);
std::string pending_event(const Pending& pending);

}  // namespace headframe
