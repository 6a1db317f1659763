#pragma once
// LEB128 varints: 7 bits per byte, lowest first.

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace headframe {

inline void put_varint(std::string& out, std::uint64_t v) {
  for (; v >= 0x80; v >>= 7) out.push_back(static_cast<char>(v | 0x80));
  out.push_back(static_cast<char>(v));
}

inline void put_signed(std::string& out, std::int64_t v) {
  put_varint(out, static_cast<std::uint64_t>(v) << 1 ^ static_cast<std::uint64_t>(v >> 63));
}

inline void put_float32(std::string& out, float v) {  // little endian
  std::uint32_t bits = 0;
  std::memcpy(&bits, &v, sizeof v);
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(bits >> 8 * i));
}

/// Accepts any bytes. After the first fault every read returns 0 and ok() stays false.
class VarintReader {
 public:
  explicit VarintReader(std::string_view bytes) : bytes_(bytes) {}

  std::uint64_t varint() {
    std::uint64_t v = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      if (bytes_.empty()) break;
      const auto byte = static_cast<unsigned char>(bytes_.front());
      bytes_.remove_prefix(1);
      v |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return v;
    }
    return fail();
  }

  std::int64_t signed_varint() {
    const std::uint64_t v = varint();
    return static_cast<std::int64_t>(v >> 1 ^ (0 - (v & 1)));
  }

  float float32() {  // little endian
    if (bytes_.size() < 4) return static_cast<float>(fail());
    std::uint32_t bits = 0;
    for (int i = 0; i < 4; ++i)
      bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes_[static_cast<std::size_t>(i)])) << 8 * i;
    bytes_.remove_prefix(4);
    float v = 0;
    std::memcpy(&v, &bits, sizeof v);
    return v;
  }

  bool ok() const { return ok_; }
  std::size_t left() const { return bytes_.size(); }
  std::string_view rest() const { return bytes_; }  // the bytes not yet read

 private:
  std::uint64_t fail() {
    ok_ = false;
    bytes_ = {};
    return 0;
  }

  std::string_view bytes_;
  bool ok_ = true;
};

}  // namespace headframe
