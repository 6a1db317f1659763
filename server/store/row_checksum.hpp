#pragma once

#include <cstdint>
#include <string_view>

namespace headframe {

/// A checksum of a row's content, to detect bits that changed on the disk (FNV-1a, 64 bits). It does not prevent
/// forgery.
class RowChecksum {
 public:
  RowChecksum& add(std::string_view bytes);
  RowChecksum& add(std::uint64_t value);
  RowChecksum& add(double value);
  /// In the form in which it is stored in a column.
  std::int64_t value() const;

 private:
  std::uint64_t sum_ = 14695981039346656037ULL;
};

}  // namespace headframe
