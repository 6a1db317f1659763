#pragma once

#include <span>

#include "server/atlas/atlas.hpp"

namespace headframe {

/// What depends on a session, for an operator who considers removing it.
struct Dependents {
  std::vector<SessionId> merged_with;  // by published alignments of its own, sorted
  bool is_anchor = false;              // of a component of several sessions, which would get another frame
  /// The parts into which its component would fall without it, by published alignments; each sorted, ordered by their
  /// first. More than one: the component would split.
  std::vector<std::vector<SessionId>> parts;
};

/// Pure.
Dependents dependents_of(SessionId session, const Atlas& atlas, std::span<const Alignment> alignments);

}  // namespace headframe
