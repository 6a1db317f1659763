#pragma once

#include <cstdint>

namespace headframe {

/// How long each stage of an attempt took.
struct StageTimes {
  double hypotheses_ms = 0;
  double sampling_ms = 0;
  double registration_ms = 0;
  double verification_ms = 0;
  double atlas_ms = 0;
  double loop_closures_ms = 0;  // of sessions that are already merged

  StageTimes& operator+=(const StageTimes& other) {
    hypotheses_ms += other.hypotheses_ms;
    sampling_ms += other.sampling_ms;
    registration_ms += other.registration_ms;
    verification_ms += other.verification_ms;
    atlas_ms += other.atlas_ms;
    loop_closures_ms += other.loop_closures_ms;
    return *this;
  }
};

/// Totals of all attempts since the server started.
struct MergeEffort {
  std::uint64_t attempts = 0;
  StageTimes stages;            // sums
  std::uint64_t withdrawn = 0;  // merges that were published and later withdrawn
};

}  // namespace headframe
