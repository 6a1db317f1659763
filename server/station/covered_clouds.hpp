#pragma once
// Clouds that may be deleted to make room, and when this happens automatically.

#include <cstdint>
#include <vector>

#include "server/store/store.hpp"

namespace headframe {

/// The clouds of one session that may be deleted.
struct CoveredClouds {
  SessionId session = 0;
  std::vector<CloudSize> clouds;
  std::uint64_t bytes = 0;   // of these clouds
  std::uint64_t stored = 0;  // number of clouds stored of the session
};

/// [store] keep: all; or newest: covered clouds are deleted while less than free_bytes are free.
struct KeepPolicy {
  bool newest = false;
  std::uint64_t free_bytes = 0;
};

/// The first clouds, in order, that have at least this many bytes together, or all.
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
