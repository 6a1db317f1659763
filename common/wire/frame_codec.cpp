#include "common/wire/frame_codec.hpp"

#include "common/wire/limits.hpp"

namespace headframe {
namespace {

constexpr std::size_t header_bytes = 4;

std::uint32_t read_length(const char* p) {
  const auto* b = reinterpret_cast<const unsigned char*>(p);
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 | std::uint32_t{b[3]};
}

}  // namespace

Result<void> append_frame(std::string& out, std::string_view payload) {
  if (payload.empty() || payload.size() > limits::frame_bytes)
    return failure(ErrorCode::internal, "a frame of " + std::to_string(payload.size()) +
                                            " bytes can not be sent; 1 to " + std::to_string(limits::frame_bytes) +
                                            " are allowed");
  const auto n = static_cast<std::uint32_t>(payload.size());
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(n >> shift & 0xff));
  out.append(payload);
  return {};
}

void FrameReader::feed(std::string_view bytes) {
  buffer_.erase(0, start_);
  start_ = 0;
  buffer_.append(bytes);
}

Result<std::optional<std::string>> FrameReader::next() {
  if (buffer_.size() - start_ < header_bytes) return std::nullopt;
  const std::size_t length = read_length(buffer_.data() + start_);
  if (length == 0 || length > limits::frame_bytes)
    return failure(ErrorCode::bad_input, "frame of " + std::to_string(length) + " bytes announced, 1 to " +
                                             std::to_string(limits::frame_bytes) +
                                             " are allowed: is the peer a headframe robot or server?");
  if (buffer_.size() - start_ - header_bytes < length) return std::nullopt;
  std::string payload = buffer_.substr(start_ + header_bytes, length);
  start_ += header_bytes + length;
  return payload;
}

}  // namespace headframe
