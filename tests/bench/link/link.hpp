#pragma once
// ./run bench link: what the link costs and what it stands.

#include <nlohmann/json.hpp>

namespace headframe::bench {

nlohmann::json link_bytes();

}  // namespace headframe::bench
