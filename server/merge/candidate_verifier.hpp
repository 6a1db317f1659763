#pragma once
// From hypotheses to verdicts: screening, evidence for each promising placement, and which further clouds would help.

#include "server/merge/long_range_check.hpp"
#include "server/merge/pair_findings.hpp"
#include "server/merge/self_similarity.hpp"
#include "server/place/descriptor_agreement.hpp"

namespace headframe {

/// A judged hypothesis.
struct Verdict {
  Judgement judgement;
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();  // where the placement was registered first, in b's frame
  std::vector<KeyframeRef> wanted = {};           // clouds that could add evidence
};

/// What the cases of a pair came to.
struct Verdicts {
  std::vector<Verdict> judged;                 // the most probable first
  std::vector<KeyframeRef> another_look = {};  // clouds with which a likely case could be tried where it was not yet
};

/// Adds to the first verdict's evidence how probable the best other placement is, and returns that placement; nullopt
/// if there is none. There must be a verdict.
std::optional<Pose> note_rival(std::vector<Verdict>& verdicts);

/// Verifies placements of pairs of sessions. Stateless. Not thread safe; the verdicts do not depend on the number of
/// threads.
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

  /// Screens the cases and judges the promising ones that differ: four, or up to ten while none of them is likely.
  /// Unless `all` is set, placements are skipped that could neither beat a judged one nor cast doubt on it. The most
  /// probable comes first. `known`: what was found of the pair elsewhere, with hypotheses that are
  /// those of the cases; nullptr: nothing. The result is the same.
  Verdicts judge_cases(const OrderedPair& pair, const std::vector<Case>& cases, bool all, const Attempt& attempt,
                       const PairFindings* known = nullptr);

  /// Of the screened cases those that judge_cases() will probably judge, as far as these two sessions say.
  std::vector<JudgedCase> judge_ahead(const OrderedPair& pair, const std::vector<Case>& cases,
                                      const std::vector<ScreeningResult>& screened, CloudSource& clouds);

  /// Judges a placement that is known to within a metre or two. Aliases, look-alikes and all other evidence that only
  /// the search of the whole pair gives are left at zero.
  Judgement judge_again(const OrderedPair& pair, const Case& at, CloudSource& clouds);

  /// The same for a placement that follows from other alignments: look-alikes elsewhere do not cast doubt on it, and
  /// changes of the mine are no excuse if either session is known to repeat itself.
  Judgement judge_contact(const OrderedPair& pair, const Case& at, CloudSource& clouds);

  /// What contradicts a placement as it is, see headframe::violation_at().
  double violation_at(const OrderedPair& pair, const Case& at, CloudSource& clouds) const;

  /// The same, with the aliases and look-alikes that each session has within itself.
  Judgement judge_placement(const OrderedPair& pair, const Pose& T_a_b, CloudSource& clouds);

  /// Requests the clouds that the verdicts want; if none wants any, all of both sessions if these have ended and the
  /// best may be right, or those for another look. Returns true if the best would be accepted but has to wait for them.
  /// awaited: the number of cases that already wait for clouds.
  bool ask_for_more(const OrderedPair& pair, const Verdicts& verdicts, std::size_t awaited,
                    const Attempt& attempt) const;

 private:
  struct Judged {
    Verdict verdict;
    std::size_t of = 0;    // the case
    Judgement alone = {};  // before anything beside these two sessions counts
  };
  std::vector<Judged> judge_hopeful(const OrderedPair& pair, const std::vector<Case>& cases,
                                    const std::vector<ScreeningResult>& screened, bool all, CloudSource& clouds,
                                    const PairFindings* known);
  Judgement judge_alone(const OrderedPair& pair, const Case& c, const ScreeningResult& screened, CloudSource& clouds);
  /// Sets what the mine shows of itself, and each of the two sessions where T_a_b puts them on each other. Similar
  /// places count wherever they are, because they say that a mine may hold copies.
  void compare_with_itself(const OrderedPair& pair, const Case& c, const Pose& T_a_b, Evidence& e) const;
  void tell_similar_places(const OrderedPair& pair, Evidence& e) const;
  std::vector<KeyframeRef> clouds_for_another_look(const OrderedPair& pair, const std::vector<Case>& cases,
                                                   const std::vector<ScreeningResult>& screened) const;
  bool ask_for_all(const OrderedPair& pair, const Attempt& attempt) const;
  bool worth_all_clouds(const OrderedPair& pair, const Verdict& best) const;
  std::set<KeyframeRef> look_farther(const OrderedPair& pair, const Case& c, Verdict& verdict, CloudSource& clouds);
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
