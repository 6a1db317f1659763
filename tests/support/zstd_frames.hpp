#pragma once
// Content as the one zstd frame in which clouds travel, and out of it again.

#include <gtest/gtest.h>
#include <zstd.h>

#include <string>

namespace headframe::test {

inline std::string compressed(const std::string& content) {
  std::string out(ZSTD_compressBound(content.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), content.data(), content.size(), 1));
  return out;
}

inline std::string content_of(const std::string& encoded) {
  std::string out(ZSTD_getFrameContentSize(encoded.data(), encoded.size()), '\0');
  EXPECT_EQ(ZSTD_decompress(out.data(), out.size(), encoded.data(), encoded.size()), out.size());
  return out;
}

}  // namespace headframe::test
