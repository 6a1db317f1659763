#pragma once
// What the verdict demands where a placement may be a copy: exact copies pass every local test, so only the length of
// the overlap, descriptors, and how well all its places agree can tell them from the place itself. Set by hand on
// worlds of equal tunnels, mines laid out of third-party tiles, generated mines and recordings; no part of the fit.

#include "server/verification/evidence.hpp"

namespace headframe {

/// What is missing of the overlap that aliases, repetition or look-alikes demand, in log-odds (0 or less).
double short_among_copies(const Evidence& evidence);

/// What speaks against a placement that descriptors, or the length of the overlap and the walls where none were
/// compared, hardly tell from another place, in log-odds (0 or less).
double hardly_told_apart(const Evidence& evidence);

}  // namespace headframe
