#pragma once

#include <functional>
#include <string>
#include <thread>

#include "tests/bench/servers/revision_book.hpp"

namespace headframe::bench {

/// An operator who makes one revision after the other, whichever server serves, and reads each.
class RevisionWatch {
 public:
  /// `http`: where a server may serve operators now, HOST:PORT; called from the thread of this.
  RevisionWatch(std::function<std::string()> http, std::string token);
  RevisionBook::Seen finish();

 private:
  void run(const std::stop_token& stop);

  const std::function<std::string()> http_;
  const std::string token_;
  RevisionBook book_;  // of the thread, until finish()
  std::jthread thread_;
};

}  // namespace headframe::bench
