#pragma once
// The atlas of a live run against the truth, at every change.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/live/live_run.hpp"

namespace headframe::bench {

/// A pair of sessions by their names, in order.
using NamedPair = std::pair<std::string, std::string>;

/// How one session lies on another, against the truth.
struct Standing {
  bool wrong = false;
  double off_m = 0;
};

/// T_a_b of two sessions in one component. Wrong: of other worlds, or, where they meet, more than 1 m (or 0.5 m and
/// twice what drift leaves of the true frames) or 5 deg off; where they do not meet, more than 10 m.
Standing standing_of(const DrivenSession& a, const DrivenSession& b, const Pose& T_a_b);

/// Whether the two come within 8 m of each other.
bool truly_meet(const DrivenSession& a, const DrivenSession& b);

/// A pair that stood wrongly, or rightly, for a while.
struct Stood {
  NamedPair pair;
  double from_s = 0, to_s = 0;
  double path_m = 0;                    // that the farther of the two drove in that time
  double off_m = 0;                     // at first
  bool at_end = false;                  // it stands still
  Evidence evidence = {};               // of the pair's own alignment at first, where it has one
  double known_a_m = 0, known_b_m = 0;  // path of both at first
};

/// What convinced for a while, told or not.
struct Claim {
  NamedPair pair;
  AlignmentState state = AlignmentState::candidate;  // ... where the evidence convinces, provisional or published
  double at_s = 0;
  Standing standing = {};
  Evidence evidence = {};
  double known_a_m = 0, known_b_m = 0;  // path of both
};

struct EndState {
  AlignmentState state = AlignmentState::rejected;
  bool together = false;  // in one component
  Pose T_a_b = Pose::Identity();
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();  // of b's path, where it comes nearest to a's
};

/// Pairs whose end differs, in words: not the same sessions together, or not by the same alignments within 5 cm; what
/// is merged through others alone lies where these put it.
std::vector<std::string> differences(const std::map<NamedPair, EndState>& one,
                                     const std::map<NamedPair, EndState>& other);

/// Keeps account of every pair of a run.
class LiveWatch {
 public:
  void look(const LiveRun& run);
  /// When nothing changes any more.
  void finish(const LiveRun& run);

  const std::vector<Stood>& wrong() const { return wrong_; }
  const std::vector<Stood>& right() const { return right_; }
  /// Of pairs that meet, of which what stood rightly was withdrawn.
  std::size_t right_withdrawn() const;
  /// Whether something provisional that robots could ask for was wrong.
  bool wrong_provisional() const { return wrong_provisional_; }
  /// Of each pair that stood rightly at the end: the path that its robots came along from the moment on when it first
  /// convinced rightly until it was told. What waiting costs.
  std::vector<double> later_m() const;
  /// Whatever convinced, waiting, provisional or published, at each new placement or state.
  const std::vector<Claim>& claims() const { return claims_; }
  static std::map<NamedPair, EndState> end_of(const LiveRun& run);

 private:
  struct Now {
    bool wrong = false;
    Stood stood;
    double max_path_m = 0;
  };
  void close(Now& now, const LiveRun& run, bool at_end);
  void note_claims(const LiveRun& run);

  std::map<std::pair<SessionId, SessionId>, Now> standing_;
  std::vector<Stood> wrong_, right_;
  std::map<AlignmentId, Claim> claimed_;
  std::vector<Claim> claims_;
  bool wrong_provisional_ = false;
};

}  // namespace headframe::bench
