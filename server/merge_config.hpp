#pragma once

namespace headframe {

/// Everything an operator may set about merging ([merge] in the configuration file); defaults live only here.
struct MergeConfig {
  int threads = 2;                  // of registration; results do not depend on it
  double accept_probability = 0.9;  // a merge is published at or above this
  double margin_probability = 0.5;  // ... when its best different hypothesis is below this
};

}  // namespace headframe
