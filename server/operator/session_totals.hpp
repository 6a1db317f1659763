#pragma once

#include <vector>

#include "server/operator/station.hpp"

namespace headframe {

/// All sessions together.
struct SessionTotals {
  std::uint64_t connected = 0, keyframes = 0, clouds = 0, bytes_received = 0, backlog = 0;
};

inline SessionTotals totals_of(const std::vector<SessionRow>& sessions) {
  SessionTotals totals;
  for (const SessionRow& row : sessions) {
    totals.connected += row.connected ? 1 : 0;
    totals.keyframes += row.keyframes;
    totals.clouds += row.clouds;
    totals.bytes_received += row.bytes_received;
    totals.backlog += row.backlog;
  }
  return totals;
}

}  // namespace headframe
