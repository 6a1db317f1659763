#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

namespace headframe::bench {

/// An operator who makes one revision after the other, whichever server serves, and reads each: two servers must never
/// show different content under the same number, nor go back behind a number that was shown.
class RevisionWatch {
 public:
  struct Seen {
    std::uint64_t revisions = 0;       // that were read
    std::uint64_t contradictions = 0;  // ... and are not what was read before
    std::string first;                 // in words
  };

  /// `http`: where a server may serve operators now, HOST:PORT; called from the thread of this.
  RevisionWatch(std::function<std::string()> http, std::string token);
  Seen finish();

 private:
  void run(const std::stop_token& stop);
  void look(std::uint64_t revision, const std::string& content);

  const std::function<std::string()> http_;
  const std::string token_;
  std::map<std::uint64_t, std::string> content_;  // of the thread, as Seen is until finish()
  Seen seen_;
  std::jthread thread_;
};

}  // namespace headframe::bench
