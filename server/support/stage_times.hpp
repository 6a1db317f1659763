#pragma once

#include <cstdint>

namespace headframe {

/// Where the time of an attempt went.
struct StageTimes {
  double hypotheses_ms = 0;
  double sampling_ms = 0;
  double registration_ms = 0;
  double verification_ms = 0;
  double atlas_ms = 0;
  double loop_closures_ms = 0;  // of what is merged already

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

/// What attempts have come to since the server began.
struct MergeEffort {
  std::uint64_t attempts = 0;
  StageTimes stages;            // summed over them
  std::uint64_t withdrawn = 0;  // merges that were published, and contradicted by what came later
};

}  // namespace headframe
