#pragma once

#include <cstdint>

namespace headframe {

/// Which keyframes' clouds a robot sends.
enum class CloudPolicy : std::uint8_t {
  on_request = 0,  // those the server asks for
  all = 1,         // all, in the background; requested ones first
  never = 2,
};

}  // namespace headframe
