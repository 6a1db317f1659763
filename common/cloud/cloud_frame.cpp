#include "common/cloud/cloud_frame.hpp"

#include <zstd.h>

#include <memory>

#include "common/cloud/cloud_form.hpp"
#include "common/wire/limits.hpp"

namespace headframe::cloud_form {
namespace {

constexpr std::size_t most_point_bytes = 9;  // 63 bits as a varint
constexpr std::size_t most_sweep_bytes = 7 * 10;
constexpr std::size_t most_content_bytes =
    limits::cloud_points * most_point_bytes + limits::cloud_sweeps * most_sweep_bytes + 16;

}  // namespace

Result<std::string> compress(const std::string& content) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, 1);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::string out(ZSTD_compressBound(content.size()), '\0');
  const std::size_t n = ZSTD_compress2(context.get(), out.data(), out.size(), content.data(), content.size());
  if (ZSTD_isError(n)) return failure(ErrorCode::internal, std::string("zstd: ") + ZSTD_getErrorName(n));
  out.resize(n);
  return out;
}

Result<std::string> decompress(std::string_view bytes) {
  if (bytes.size() > limits::cloud_bytes) return damaged("larger than the limit");
  const auto announced = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (announced == ZSTD_CONTENTSIZE_ERROR || announced == ZSTD_CONTENTSIZE_UNKNOWN)
    return damaged("not a zstd frame with its content size");
  if (announced > most_content_bytes) return damaged("content of " + std::to_string(announced) + " bytes announced");
  if (ZSTD_findFrameCompressedSize(bytes.data(), bytes.size()) != bytes.size())
    return damaged("cut short, or bytes after its end");
  std::string content(announced, '\0');
  const std::size_t n = ZSTD_decompress(content.data(), content.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(n)) return damaged(ZSTD_getErrorName(n));
  if (n != content.size()) return damaged("content shorter than announced");
  return content;
}

}  // namespace headframe::cloud_form
