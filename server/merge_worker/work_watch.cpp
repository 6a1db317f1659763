#include "server/merge_worker/work_watch.hpp"

#include <cmath>

namespace headframe {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

std::string why_stuck(const std::optional<WorkPiece>& piece, Clock::time_point now, double stuck_s) {
  if (!piece) return {};
  const double taken_s = std::chrono::duration<double>(now - piece->began).count();
  if (taken_s < stuck_s) return {};
  const std::string whose = piece->a == piece->b
                                ? "session " + std::to_string(piece->a)
                                : "sessions " + std::to_string(piece->a) + " and " + std::to_string(piece->b);
  return "merging is stuck: work on " + whose + " has taken " + std::to_string(std::llround(taken_s)) + " s";
}

WorkWatch::WorkWatch(double budget_s)
    : budget_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(budget_s))),
      thread_([this](const std::stop_token& stop) { watch(stop); }) {}

void WorkWatch::on(SessionId a, SessionId b) {
  const std::lock_guard lock(mutex_);
  const bool wakes = !piece_;  // else the thread waits for an earlier deadline already
  piece_ = WorkPiece{a, b, Clock::now()};
  flag_ = stopped_;
  if (wakes) changed_.notify_all();
}

void WorkWatch::off() {
  const std::lock_guard lock(mutex_);
  piece_.reset();
  flag_ = stopped_;
}

std::optional<WorkPiece> WorkWatch::piece() const {
  const std::lock_guard lock(mutex_);
  return piece_;
}

void WorkWatch::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  flag_ = true;
}

bool WorkWatch::stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

void WorkWatch::watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return piece_.has_value(); }) && !stop.stop_requested()) {
    const auto deadline = piece_->began + budget_;
    if (Clock::now() < deadline) {
      changed_.wait_until(lock, stop, deadline, [] { return false; });
      continue;
    }
    flag_ = true;
    changed_.wait(lock, stop, [&, began = piece_->began] { return !piece_ || piece_->began != began; });
  }
}

}  // namespace headframe
