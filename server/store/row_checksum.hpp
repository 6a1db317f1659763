#pragma once

#include <cstdint>
#include <string_view>

namespace headframe {

/// A checksum over what a row holds, so that a bit that turned on the disk is noticed (FNV-1a, 64 bits). Nobody is kept
/// from forging it.
class RowChecksum {
 public:
  RowChecksum& add(std::string_view bytes);
  RowChecksum& add(std::uint64_t value);
  RowChecksum& add(double value);
  /// As a column holds it.
  std::int64_t value() const;

 private:
  std::uint64_t sum_ = 14695981039346656037ULL;
};

}  // namespace headframe
