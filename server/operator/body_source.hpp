#pragma once

#include <optional>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// A response body that is made piece by piece, from disk. next() may block: call it from the disk pool, one call at a
/// time. An empty piece means "still preparing", no piece the end. A failure ends the body; one that comes before the
/// first bytes can still become an error response.
class BodySource {
 public:
  virtual ~BodySource() = default;
  virtual Result<std::optional<std::string>> next() = 0;
};

}  // namespace headframe
