#pragma once

#include <map>
#include <string>

namespace headframe::conformance {

/// What a client gets wrong, by kind: the first of each kind in words, and how often. Not thread safe.
class Findings {
 public:
  struct Finding {
    std::string first;
    int times = 0;
  };

  /// kind: a short name that stays, e.g. "chunk-size". what: what was seen, and what the protocol page says.
  void wrong(const std::string& kind, const std::string& what) {
    Finding& finding = found_[kind];
    if (finding.times++ == 0) finding.first = what;
  }
  void check(bool holds, const std::string& kind, const std::string& what) {
    holds ? void(++passed_) : wrong(kind, what);
  }

  const std::map<std::string, Finding>& found() const { return found_; }
  int passed() const { return passed_; }

 private:
  std::map<std::string, Finding> found_;
  int passed_ = 0;  // checks that held
};

}  // namespace headframe::conformance
