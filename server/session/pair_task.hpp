#pragma once
// The part of merging that other servers may help with: searching a pair of sessions, or how a session looks like
// itself. It depends on nothing but what is stored of these sessions.

#include <optional>
#include <string>
#include <vector>

#include "server/session/ids.hpp"

namespace headframe {

/// Of two sessions, b is to be placed on a; a == b: how the session looks like itself.
struct PairTask {
  SessionId a = 0, b = 0;
  std::uint64_t keyframes_a = 0, keyframes_b = 0;  // it is about so many of each, from the first on
  bool complete_a = false, complete_b = false;     // no further ones are expected
  /// 64 bytes: digests of all that the result depends on, of a and then of b. Whoever finds other ones knows other
  /// data, or computes otherwise, and must not answer.
  std::string digest = {};
};

/// Where the merge pipeline asks for results that others have computed. Called by one thread. Nothing here is an error
/// to the caller: where others can not be reached, it computes everything itself.
class PairHelpers {
 public:
  enum class Turn {
    done,    // here is the result
    mine,    // nobody works on it, and from now on nobody else will
    others,  // somebody works on it
  };
  struct Answer {
    Turn turn = Turn::mine;
    std::string result = {};
  };

  virtual ~PairHelpers() = default;
  /// Whether it makes sense to announce anything. Does not wait.
  virtual bool any() = 0;
  /// These will be needed, in this order and before all that were announced earlier.
  virtual void announce(const std::vector<PairTask>& tasks) = 0;
  /// Does not wait for the result.
  virtual Answer ask(const PairTask& task) = 0;
  /// The first task on which nobody works, which the caller has to compute now.
  virtual std::optional<PairTask> claim() = 0;
  /// Waits for the result that somebody else computes; not for long, should they have gone.
  virtual Answer wait(const PairTask& task) = 0;
  /// They are not needed any more.
  virtual void withdraw(const std::vector<PairTask>& tasks) = 0;
};

}  // namespace headframe
