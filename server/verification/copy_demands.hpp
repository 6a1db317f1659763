#pragma once
// What the verdict demands where a placement may be a copy: exact copies pass every local test, so only the length of
// the overlap, descriptors, and how well all its places agree can tell them from the place itself. Set by hand on
// worlds of equal tunnels, mines laid out of third-party tiles, generated mines and recordings; no part of the fit of
// the verdict's weights.

#include "server/verification/evidence.hpp"

namespace headframe {

/// What is missing of the overlap that aliases, repetition or look-alikes demand, in log-odds (0 or less).
double short_among_copies(const Evidence& evidence);

/// What speaks against a placement that descriptors, or the length of the overlap and the walls where none were
/// compared, hardly tell from another place, in log-odds (0 or less).
double hardly_told_apart(const Evidence& evidence);

/// What speaks against a short overlap with few descriptors if little tells it from a copy of a tile or two, in
/// log-odds (0 or less): walls farther off that match (Evidence::support), surfaces among which points hardly scatter,
/// descriptors that agree; more is asked for, the longer the overlap. Weighed as tile_weights.hpp says. Nothing from 44
/// m (fully up to 36) or twelve descriptors (up to eight) on, or where walls farther off were not compared.
double short_and_little_tells(const Evidence& evidence);

}  // namespace headframe
