#pragma once

#include <vector>

#include "server/session/ids.hpp"

namespace headframe {

/// How often a session looks like itself at other places, and the data that this was found from.
struct SelfLikeness {
  double path_m = -1;               // length of the session then; negative: never searched
  std::size_t clouds = 0;           // number stored then
  double aliases = 0;               // see Evidence::aliases
  double look_alikes = 0;           // see Evidence::look_alikes
  double similar_places = 0;        // see Evidence::similar_places
  std::vector<KeyframeRef> wanted;  // clouds that would allow a closer look at places whose walls look alike

  bool operator==(const SelfLikeness&) const = default;
};

}  // namespace headframe
