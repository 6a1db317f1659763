#pragma once

#include "server/place/wall_search.hpp"
#include "server/registration/registration_engine.hpp"
#include "server/verification/evidence.hpp"

namespace headframe {

/// A probability. A placement accepted with less waits for more path and for all clouds of its overlap. Set by hand on
/// live drives of the recordings and of drawn mines (seed 310000), where a placement in a smooth tunnel had .944 on
/// some of its clouds and .856 on all of them.
inline constexpr double beyond_doubt = 0.98;

/// Everything an operator may set about merging ([merge] in the configuration file); defaults live only here.
struct MergeConfig : VerdictThresholds {
  RegistrationEngine registration = RegistrationEngine::vgicp;
  int threads = 2;            // of correlation and registration; results do not depend on it
  double shown_m = 60;        // a growing session waits until shared path and path driven since add up to this, ...
  double shown_more_m = 15;   // ... plus this for each similar place, up to four, ...
  double shown_doubt_m = 30;  // ... plus this for each unit of log-odds below a probability of .98, up to two
  double look_alikes = 1.5;   // from this many similar places on a copy cannot be ruled out: others are waited for
  double provisional_m = 40;  // robots that ask for provisional merges get them when no more than this is missing ...
  double provisional_probability = 0.97;  // ... and the probability is at least this
  int placements = 1000;                  // results of the wall search that are refined, for each pair
  WallSearchSteps wall_search;            // step sizes of the wall search
  int hypotheses = 40;                    // placements whose walls hardly contradict each other, screened for each pair
  int partners = 16;                      // other sessions of a site that are all tried, see most_in_vain()
  int searches = 4;                       // pairs of sessions whose walls are searched again in one attempt
  int clouds_requested = 4;  // of each session for the first look at a hypothesis; twice as many while in doubt
  int clouds_mb = 256;       // memory for prepared clouds, ...
  int places_mb = 768;       // ... for submaps and the sweeps they use for lines of sight ...
  int walls_mb = 64;         // ... and for wall maps; the least recently used are discarded and rebuilt when needed

  /// An attempt ends when this many of the `others` gave nothing: if they are more than `partners`, those that are
  /// tried first are the most promising ones.
  int most_in_vain(std::size_t others) const {
    return others <= static_cast<std::size_t>(partners) ? partners : partners * 9 / 16;
  }
};

}  // namespace headframe
