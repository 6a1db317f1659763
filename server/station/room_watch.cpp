#include "server/station/room_watch.hpp"

#include <spdlog/spdlog.h>

#include <memory>
#include <optional>

namespace headframe {
namespace {

constexpr int pauses_in_vain = 30;  // checks are costly, so they are rarer while nothing may be deleted

}  // namespace

RoomWatch::~RoomWatch() {
  {
    const std::lock_guard lock(bell_->mutex);
    stopping_ = true;
  }
  bell_->wake.notify_all();
  if (thread_.joinable()) thread_.join();
}

void RoomWatch::start(const KeepPolicy& policy) {
  if (policy.newest && !thread_.joinable()) thread_ = std::thread([this] { run(); });
}

void RoomWatch::run() {
  for (std::unique_lock lock(bell_->mutex); !stopping_;) {
    lock.unlock();
    if (const auto gone = look(); !gone) spdlog::error("no room was made: {}", gone.error().message);
    lock.lock();
    bell_->wake.wait_for(lock, said_ ? pauses_in_vain * pause_ : pause_, [&] { return stopping_; });
  }
}

Result<std::vector<CoveredClouds>> RoomWatch::look() {
  std::vector<CoveredClouds> none;
  const auto free_bytes = station_.free_bytes();
  if (!free_bytes) return tl::unexpected(free_bytes.error());
  const KeepPolicy policy = station_.keep_policy();
  const bool is_short = policy.newest && *free_bytes && **free_bytes < policy.free_bytes;
  if (!is_short) said_ = false;
  if (!is_short) return none;
  const auto covered = station_.covered_clouds();
  if (!covered) return tl::unexpected(covered.error());
  std::vector<CoveredClouds> gone = first_bytes(*covered, policy.free_bytes + policy.free_bytes / 2 - **free_bytes);
  if (!gone.empty()) said_ = false;
  if (gone.empty() && !std::exchange(said_, true))
    spdlog::warn("{} MiB are free, less than the {} that [store] free_mib asks for, and no cloud may go",
                 **free_bytes >> 20, policy.free_bytes >> 20);
  if (auto done = let_go(gone); !done) return tl::unexpected(done.error());
  for (const CoveredClouds& of : gone)
    spdlog::info("{} clouds of session {} were let go, {} bytes: later sessions keep that rock", of.clouds.size(),
                 of.session, of.bytes);
  return gone;
}

/// Waits until they are deleted, or the server stops.
Result<void> RoomWatch::let_go(const std::vector<CoveredClouds>& clouds) {
  if (clouds.empty()) return {};
  const auto answer = std::make_shared<std::optional<Result<void>>>();
  station_.let_go(clouds, [bell = bell_, answer](const Result<void>& done) {
    const std::lock_guard lock(bell->mutex);
    *answer = done;
    bell->wake.notify_all();
  });
  std::unique_lock lock(bell_->mutex);
  bell_->wake.wait(lock, [&] { return answer->has_value() || stopping_; });
  return answer->value_or(failure(ErrorCode::unavailable, "the server stops"));
}

}  // namespace headframe
