#pragma once

#include <span>

#include "server/atlas/atlas.hpp"

namespace headframe {

/// What hangs on a session, for whoever wants to take it out.
struct Dependents {
  std::vector<SessionId> merged_with;  // by published alignments of its own, sorted
  bool is_anchor = false;              // of a component of several sessions: it gets another frame
  /// What is left of its component without it, as published alignments hold it together; each sorted, by the first.
  /// More than one: it comes apart.
  std::vector<std::vector<SessionId>> parts;
};

/// Pure.
Dependents dependents_of(SessionId session, const Atlas& atlas, std::span<const Alignment> alignments);

}  // namespace headframe
