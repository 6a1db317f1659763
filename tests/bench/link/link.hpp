#pragma once
// ./run bench link: what the link costs and what it stands.

#include <nlohmann/json.hpp>

namespace headframe::bench {

/// Bytes of a keyframe as they cross the link under TLS, of a point at 1 cm, and how fast clouds are coded.
nlohmann::json link_bytes();

/// What honest robots notice of attacks, of each kind by itself; only: those whose names have these words.
nlohmann::json link_hostile(double seconds, const std::string& only);

/// Keyframe to ack over a link of 64 kbit/s, alone and while the robot is told without a pause what others know.
nlohmann::json link_around(double seconds);

/// Two robots of the demo's mine, clouds on request: what their merge costs.
nlohmann::json link_merge();

}  // namespace headframe::bench
