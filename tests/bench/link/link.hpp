#pragma once
// ./run bench link: what the link costs and what it stands.

#include <nlohmann/json.hpp>

namespace headframe::bench {

/// Bytes of a keyframe as they cross the link under TLS, of a point at 1 cm, and how fast clouds are coded.
nlohmann::json link_bytes();

/// What robots notice of hostile peers.
nlohmann::json link_hostile(double seconds);

/// Two robots of the demo's mine, clouds on request: what their merge costs.
nlohmann::json link_merge();

}  // namespace headframe::bench
