#include "tests/support/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>

extern char** environ;

namespace headframe::test {
namespace {

using Clock = std::chrono::steady_clock;

auto failed(const std::string& what) { return failure(ErrorCode::unavailable, what + ": " + std::strerror(errno)); }

int exit_status(int raw) { return WIFEXITED(raw) ? WEXITSTATUS(raw) : 128 + WTERMSIG(raw); }

}  // namespace

struct Process::State {
  pid_t pid = -1;
  int output = -1;  // read end, -1: none
  std::string buffer;
  int status = -1;

  ~State() {
    if (pid > 0 && status < 0) {
      ::kill(pid, SIGKILL);
      ::waitpid(pid, nullptr, 0);
    }
    if (output >= 0) ::close(output);
  }

  /// Reads what there is; false at the end of output or when the time is over.
  bool fill(Clock::time_point deadline) {
    if (output < 0) return false;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd waiting{output, POLLIN, 0};
    if (left <= 0 || ::poll(&waiting, 1, static_cast<int>(left)) <= 0) return false;
    std::array<char, 4096> bytes;
    const ssize_t n = ::read(output, bytes.data(), bytes.size());
    if (n <= 0) return false;
    buffer.append(bytes.data(), static_cast<std::size_t>(n));
    return true;
  }
};

Process::Process(std::unique_ptr<State> state) : state_(std::move(state)) {}
Process::Process(Process&&) noexcept = default;
Process& Process::operator=(Process&&) noexcept = default;
Process::~Process() = default;

Result<Process> Process::start(const std::vector<std::string>& argv, const std::string& log) {
  std::array<int, 2> ends{-1, -1};
  if (log.empty() ? ::pipe2(ends.data(), O_CLOEXEC) != 0
                  : (ends[1] = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)) < 0)
    return failed("output of " + argv[0]);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  std::vector<char*> arguments;
  arguments.reserve(argv.size() + 1);
  for (const std::string& a : argv) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  auto state = std::make_unique<State>();
  errno = ::posix_spawn(&state->pid, argv[0].c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  state->output = ends[0];
  if (errno != 0) {
    state->pid = -1;
    return failed("can not start " + argv[0]);
  }
  return Process(std::move(state));
}

Result<std::string> Process::read_line(std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  while (true) {
    if (const auto end = state_->buffer.find('\n'); end != std::string::npos) {
      std::string line = state_->buffer.substr(0, end);
      state_->buffer.erase(0, end + 1);
      return line;
    }
    if (!state_->fill(deadline)) return failure(ErrorCode::unavailable, "no line came; so far: " + state_->buffer);
  }
}

int Process::poll() {
  int raw = 0;
  if (state_->status < 0 && ::waitpid(state_->pid, &raw, WNOHANG) == state_->pid) state_->status = exit_status(raw);
  return state_->status;
}

Result<Process::Ended> Process::wait(std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  while (state_->fill(deadline)) {
  }
  while (poll() < 0) {  // its output has ended, so it is about to end, or the time is over
    if (Clock::now() > deadline) return failure(ErrorCode::unavailable, "it still runs; output: " + state_->buffer);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return Ended{state_->status, state_->buffer};
}

void Process::signal(int number) const {
  if (state_->status < 0) ::kill(state_->pid, number);
}

int Process::pid() const { return state_->pid; }

std::string program(const std::string& name) {
  const auto self = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const auto beside = self / name;
  return (std::filesystem::exists(beside) ? beside : self.parent_path() / "bin" / name).string();
}

}  // namespace headframe::test
