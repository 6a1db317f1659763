#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// A response body that is produced in pieces, usually from the disk. next() may block: call it on the disk pool, one
/// call at a time. An empty piece means that there is no data yet; nullopt means the end. After a failure the body is
/// over; a failure before the first bytes can still become an error response.
class BodySource {
 public:
  virtual ~BodySource() = default;
  virtual Result<std::optional<std::string>> next() = 0;
  /// The size of the whole body, known from the first piece that is not empty; nullopt: not known.
  virtual std::optional<std::uint64_t> total_bytes() const { return std::nullopt; }
};

}  // namespace headframe
