#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace headframe::bench {

/// What servers said that revisions are: two must never show different content under the same number, nor go back
/// behind a number that was shown.
class RevisionBook {
 public:
  struct Seen {
    std::uint64_t revisions = 0;       // that were read
    std::uint64_t contradictions = 0;  // ... and are not what was read before
    std::string first;                 // in words
  };

  void look(std::uint64_t revision, const std::string& content);
  const Seen& seen() const { return seen_; }

 private:
  std::map<std::uint64_t, std::string> content_;
  Seen seen_;
};

}  // namespace headframe::bench
