#pragma once

#include <vector>

#include "common/endpoint.hpp"
#include "common/result.hpp"
#include "server/store/server_record.hpp"

namespace headframe {

enum class Door { robots, operators };

/// Where a server that stands by, and listens at `own`, passes connections on to: the same door of the server that is
/// active. unavailable: none is active, or it is one of an older version; refused: it is not reached from here, with
/// what to set. A server on the loopback is reached only from the same loopback: what is served there in the clear must
/// not be reached from elsewhere. Pure.
Result<Endpoint> relay_target(const std::vector<ServerRecord>& servers, Door door, const Endpoint& own);

}  // namespace headframe
