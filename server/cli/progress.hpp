#pragma once

#include <unistd.h>

#include <iostream>
#include <string>

namespace headframe {

/// A progress line on stderr that overwrites itself on a terminal, and is written once for each change elsewhere.
class Progress {
 public:
  explicit Progress(bool wanted) : wanted_(wanted) {}
  ~Progress() {
    if (terminal_ && !last_.empty()) std::cerr << '\n';
  }
  void show(const std::string& line) {
    if (!wanted_ || line == last_) return;
    std::cerr << (terminal_ ? "\r\x1b[K" : "") << line << (terminal_ ? "" : "\n") << std::flush;
    last_ = line;
  }

 private:
  const bool wanted_;
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  std::string last_;
};

}  // namespace headframe
