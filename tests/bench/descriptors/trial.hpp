#pragma once
// One descriptor family on two drives.

#include <vector>

#include "common/descriptor/family.hpp"
#include "tests/bench/descriptors/retrieval.hpp"
#include "tests/bench/descriptors/views.hpp"

namespace headframe::bench {

/// A drive's descriptors as they reach the server, rounded as on the wire; with no q where the family refused the scan.
/// The robot stands turned by turned_rad at every view. Runs on all cores.
std::vector<Descriptor> describe(const DescriptorFamily& family, const Drive& drive, double turned_rad = 0);

/// Bytes of q and w on the wire; 0 when the descriptor does not fit there.
std::size_t wire_bytes(const Descriptor& descriptor);

/// Asks the server's exact index of drive a for the neighbours of each of b.
Answers ask(const DescriptorFamily& family, const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
            const Truth& truth);

}  // namespace headframe::bench
