#include "server/merge_worker/work_mark.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>

namespace headframe {
namespace {

std::atomic<int> opened_last = -1;

extern "C" void on_fault(int signal) {
  WorkMark::died();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

Result<WorkMark> WorkMark::open(const std::filesystem::path& file) {
  const int opened = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (opened < 0)
    return failure(ErrorCode::unavailable, file.string() + " can not be written: " + std::strerror(errno));
  Left left;
  if (::pread(opened, &left, sizeof left, 0) != static_cast<ssize_t>(sizeof left) || left.a < 0 || left.b < 0 ||
      (left.end != End::killed && left.end != End::died))
    left = {};
  WorkMark mark(opened, left);
  mark.off();
  opened_last = opened;
  return mark;
}

WorkMark::WorkMark(WorkMark&& other) noexcept : file_(std::exchange(other.file_, -1)), left_(other.left_) {}

WorkMark::~WorkMark() {
  if (file_ < 0) return;
  int own = file_;
  opened_last.compare_exchange_strong(own, -1);
  ::close(file_);
}

void WorkMark::write(const Left& now) const {
  (void)!::pwrite(file_, &now, sizeof now, 0);  // if the disk is full, no session is blamed
}

void WorkMark::died() {
  const int file = opened_last;
  End end = End::well;
  const auto at = static_cast<off_t>(offsetof(Left, end));
  if (file < 0 || ::pread(file, &end, sizeof end, at) != static_cast<ssize_t>(sizeof end) || end == End::well) return;
  end = End::died;
  (void)!::pwrite(file, &end, sizeof end, at);
}

void WorkMark::watch_for_faults() {
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, on_fault);
}

}  // namespace headframe
