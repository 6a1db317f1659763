#pragma once
// From cases to verdicts: screening, evidence for each hopeful one, and what would tell more.

#include "server/merge/long_range_check.hpp"
#include "server/merge/self_similarity.hpp"
#include "server/place/descriptor_agreement.hpp"

namespace headframe {

/// A hypothesis as it was judged; with rivals the runner-up can be told.
struct Verdict {
  Judgement judgement;
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();  // where the placement was registered first, in b's frame
  std::vector<KeyframeRef> wanted = {};           // clouds that could tell more
};

/// Verifies placements of pairs of sessions. Keeps nothing of its own. Not thread safe; the verdicts do not depend on
/// the number of threads.
class CandidateVerifier {
 public:
  CandidateVerifier(const MergeConfig& config, const SessionMap& sessions, SessionSubmaps& submaps,
                    SelfSimilarity& self, const CloudRequests& requests)
      : config_(config),
        judge_(judge_config(config)),
        sessions_(sessions),
        submaps_(submaps),
        self_(self),
        requests_(requests) {}

  /// Screens the cases; the hopeful ones that differ are judged, four at most, and those that could not cast doubt on a
  /// better one only when all are asked for. Best first.
  std::vector<Verdict> judge_cases(const OrderedPair& pair, const std::vector<Case>& cases, bool all,
                                   const Attempt& attempt);

  /// The verdict on a placement that is trusted to within a metre or two; aliases, look-alikes and whatever else only
  /// the search of the whole pair tells are left at nothing.
  Judgement judge_again(const OrderedPair& pair, const Case& at, CloudSource& clouds);

  /// The same where others say that the two lie there: look-alikes elsewhere cast no doubt on it, and changes of the
  /// mine are no excuse where either session is known to repeat itself.
  Judgement judge_contact(const OrderedPair& pair, const Case& at, CloudSource& clouds);

  /// The same with what the sessions' likeness to themselves tells.
  Judgement judge_placement(const OrderedPair& pair, const Pose& T_a_b, CloudSource& clouds);

  /// Asks for what the verdicts want. True: the best would be believed but for that, and waits for it. awaited: cases
  /// that wait for clouds already.
  bool ask_for_more(const OrderedPair& pair, const std::vector<Verdict>& verdicts, std::size_t awaited,
                    const Attempt& attempt) const;

 private:
  struct Judged {
    Verdict verdict;
    std::size_t of = 0;  // the case
  };
  std::vector<Judged> judge_hopeful(const OrderedPair& pair, const std::vector<Case>& cases,
                                    const std::vector<ScreeningResult>& screened, bool all, CloudSource& clouds);
  void weigh_among(const std::vector<Judged>& all, const OrderedPair& pair, const Case& c, Verdict& verdict,
                   CloudSource& clouds);

  const MergeConfig config_;
  const JudgeConfig judge_;
  const SessionMap& sessions_;
  SessionSubmaps& submaps_;
  SelfSimilarity& self_;
  const CloudRequests& requests_;
};

}  // namespace headframe
