#include "server/operator/backup_body.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr std::uint64_t piece_bytes = 1U << 18U;

}  // namespace

Result<void> BackupBody::make() {
  const auto made = station_.backup();
  if (!made) return tl::unexpected(made.error());
  file_.open(*made, std::ios::binary);
  std::error_code error;
  bytes_ = std::filesystem::file_size(*made, error);
  const bool sound = file_ && !error;
  std::filesystem::remove(*made, error);
  if (!sound) return failure(ErrorCode::unavailable, made->string() + " was written and can not be read");
  return {};
}

Result<std::optional<std::string>> BackupBody::next() {
  if (!bytes_)
    if (auto made = make(); !made) return tl::unexpected(made.error());
  std::string piece(std::min(piece_bytes, *bytes_ - sent_), '\0');
  if (piece.empty()) return std::nullopt;
  if (!file_.read(piece.data(), static_cast<std::streamsize>(piece.size())))
    return failure(ErrorCode::unavailable, "the backup can not be read from the server's disk");
  sent_ += piece.size();
  return piece;
}

}  // namespace headframe
