#pragma once

#include "server/place/wall_search.hpp"
#include "server/registration/registration_engine.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// A probability. What is accepted with less waits for more path and for all clouds of its overlap. Set by hand on live
/// drives of the recordings and of drawn mines (seed 310000): on some of its clouds a placement in a smooth tunnel had
/// .944 and on all of them .856.
inline constexpr double beyond_doubt = 0.98;

/// Everything an operator may set about merging ([merge] in the configuration file); defaults live only here.
struct MergeConfig : VerdictThresholds {
  RegistrationEngine registration = RegistrationEngine::vgicp;
  int threads = 2;            // of correlation and registration; results do not depend on it
  double shown_m = 60;        // a growing session waits until path shared and path since make up so much, ...
  double shown_more_m = 15;   // ... and so much more for each look-alike of its places, up to four, ...
  double shown_doubt_m = 30;  // ... and for each unit of log-odds below a probability of .98, up to two
  double look_alikes = 2;     // from so many on two sessions alone can not tell a copy: others are waited for too
  double provisional_m = 40;  // robots that ask for it are told when no more than so much is missing, ...
  double provisional_probability = 0.97;  // ... and it is so probable
  int placements = 1000;                  // of the wall search that are refined, for each pair
  WallSearchSteps wall_search;            // which are tried
  int hypotheses = 40;                    // of wall maps that hardly contradict each other, screened for each pair
  int partners = 16;         // an attempt ends when so many sessions came to nothing, those that look most alike first
  int searches = 4;          // pairs of sessions whose walls are searched anew in one attempt
  int clouds_requested = 4;  // of each session for a first look at a hypothesis; twice as many while in doubt
  int clouds_mb = 256;       // memory for prepared clouds, ...
  int places_mb = 768;       // ... for summed up surroundings, and the sweeps they look from ...
  int walls_mb = 64;         // ... and for drawn walls; what was used least recently is made anew
};

}  // namespace headframe
