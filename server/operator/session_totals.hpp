#pragma once

#include <vector>

#include "server/station/station.hpp"

namespace headframe {

/// Sums over all sessions.
struct SessionTotals {
  std::uint64_t connected = 0, keyframes = 0, clouds = 0, bytes_received = 0, cloud_bytes = 0, backlog = 0, aside = 0;
};

inline SessionTotals totals_of(const std::vector<SessionRow>& sessions) {
  SessionTotals totals;
  for (const SessionRow& row : sessions) {
    totals.connected += row.connected ? 1 : 0;
    totals.keyframes += row.keyframes;
    totals.clouds += row.clouds;
    totals.bytes_received += row.bytes_received;
    totals.cloud_bytes += row.cloud_bytes;
    totals.backlog += row.backlog;
    totals.aside += row.why_aside.empty() ? 0 : 1;
  }
  return totals;
}

}  // namespace headframe
