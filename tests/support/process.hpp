#pragma once
// Child processes for tests and the demo: the real programs, started as a user would.

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe::test {

/// A running child. Its standard output and error go to one pipe (or to a file). Killed when destroyed. Not thread
/// safe.
class Process {
 public:
  /// argv[0] is the program's path. With `log`, the output goes to that file and read_line() gives nothing.
  static Result<Process> start(const std::vector<std::string>& argv, const std::string& log = "");

  Process(Process&&) noexcept;
  Process& operator=(Process&&) noexcept;
  ~Process();

  /// The next line of output, or an error when the child closed it or nothing came in time.
  Result<std::string> read_line(std::chrono::milliseconds timeout);

  /// Everything up to the end of its output, then the exit status as a shell gives it (128 + signal).
  struct Ended {
    int status = 0;
    std::string output;
  };
  Result<Ended> wait(std::chrono::milliseconds timeout);

  /// The exit status if it has ended, without waiting; -1 if it runs.
  int poll();

  void signal(int number) const;
  int pid() const;

 private:
  struct State;
  explicit Process(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Folder of the built programs, beside the running one: build/PRESET/bin.
std::string program(const std::string& name);

}  // namespace headframe::test
