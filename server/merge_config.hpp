#pragma once

#include <cstddef>

namespace headframe {

/// Everything an operator may set about merging ([merge] in the configuration file); defaults live only here.
struct MergeConfig {
  int threads = 2;                     // of correlation and registration; results do not depend on it
  double accept_probability = 0.9;     // a merge is published at or above this ...
  double runner_up_share = 0.1;        // ... when its runner-up's odds stay below this share of its own
  double candidate_probability = 0.2;  // shown as a candidate at or above this
  double least_path_m = 50;            // a growing session waits until it has come so far, or its robot asks
  double shown_m = 60;                 // ... and while it grows, until path shared and path since make up so much
  int hypotheses = 40;                 // of wall maps that hardly contradict each other, screened for each pair
  int searches = 4;                    // pairs of sessions whose walls are searched anew in one attempt
  int clouds_requested = 4;            // of each session for a first look at a hypothesis; twice as many while in doubt
  int clouds_mb = 256;                 // memory for prepared clouds, ...
  int places_mb = 768;                 // ... for summed up surroundings, and the sweeps they look from ...
  int walls_mb = 64;                   // ... and for drawn walls; what was used least recently is made anew
};

}  // namespace headframe
