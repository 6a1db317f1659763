#pragma once

#include <vector>

#include "server/session/ids.hpp"

namespace headframe {

/// How often a session looks like itself elsewhere, and what that was found from.
struct SelfLikeness {
  double path_m = -1;               // of the session then; negative: nobody has looked
  std::size_t clouds = 0;           // stored then
  double aliases = 0;               // see Evidence::aliases
  double look_alikes = 0;           // see Evidence::look_alikes
  std::vector<KeyframeRef> wanted;  // clouds of spots whose walls look alike, and that nobody has looked at closely

  bool operator==(const SelfLikeness&) const = default;
};

}  // namespace headframe
