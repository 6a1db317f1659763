#pragma once
// Frames on the wire: 4 bytes of payload length (big endian, unsigned), then the payload, one protobuf message.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

inline constexpr std::uint32_t protocol_version = 1;

/// Appends one frame to `out`. The payload must be 1 to limits::frame_bytes long (else: internal).
Result<void> append_frame(std::string& out, std::string_view payload);

/// Takes bytes as they arrive and returns whole payloads. Holds at most one frame and what was fed last. Not thread
/// safe.
class FrameReader {
 public:
  void feed(std::string_view bytes);

  /// The next payload; nullopt: more bytes are needed. A length of 0 or above the limit is bad_input for good, because
  /// the stream cannot be read any further.
  Result<std::optional<std::string>> next();

 private:
  std::string buffer_;
  std::size_t start_ = 0;
};

}  // namespace headframe
