#pragma once

#include <string>

#include "common/result.hpp"

namespace headframe {

/// The operator's token: of `file` when one is named, of the environment's HEADFRAME_TOKEN, or of
/// headframe-data/operator.token, which `./run serve` makes. Empty when none of them is there: a server that runs with
/// --insecure wants none. There is no option for the token itself, since every process can read another's arguments.
Result<std::string> find_token(const std::string& file);

}  // namespace headframe
