#pragma once

#include <cstdint>
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
  /// Of the whole body, when the first piece that is not empty has been made; none: not known.
  virtual std::optional<std::uint64_t> total_bytes() const { return std::nullopt; }
};

}  // namespace headframe
