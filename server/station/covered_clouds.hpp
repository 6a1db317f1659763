#pragma once
// Clouds that may go so that others find room, and when they go by themselves.

#include <cstdint>
#include <vector>

#include "server/store/store.hpp"

namespace headframe {

/// What of a session may go.
struct CoveredClouds {
  SessionId session = 0;
  std::vector<CloudSize> clouds;
  std::uint64_t bytes = 0;   // of these
  std::uint64_t stored = 0;  // clouds that the session has
};

/// [store] keep: all; or newest: covered clouds go while less than free_bytes are left.
struct KeepPolicy {
  bool newest = false;
  std::uint64_t free_bytes = 0;
};

/// The first of them that make up so many bytes, or all.
inline std::vector<CoveredClouds> first_bytes(const std::vector<CoveredClouds>& covered, std::uint64_t bytes) {
  std::vector<CoveredClouds> out;
  std::uint64_t taken = 0;
  for (const CoveredClouds& of : covered) {
    if (taken >= bytes) break;
    CoveredClouds& some = out.emplace_back(CoveredClouds{of.session, {}, 0, of.stored});
    for (const CloudSize& cloud : of.clouds) {
      if (taken >= bytes) break;
      some.clouds.push_back(cloud);
      some.bytes += cloud.bytes;
      taken += cloud.bytes;
    }
  }
  return out;
}

}  // namespace headframe
