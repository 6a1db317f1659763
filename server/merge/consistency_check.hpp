#pragma once
// Checks pairs of sessions that a merge by way of other sessions would bring together: before maps merge, each pair
// that would come to overlap is judged where it meets. An exact copy of a tunnel passes every test of its own pair;
// only its surroundings in a third session's map give it away.

#include "server/merge/alignment_book.hpp"
#include "server/merge/candidate_verifier.hpp"

namespace headframe {

/// The placement of two sessions that follows from the alignments of others.
struct ImpliedPlacement {
  SessionId a = 0, b = 0;  // a < b
  Pose T_a_b = Pose::Identity();
};

/// Keeps the results for each pair. Not thread safe.
class ConsistencyCheck {
 public:
  ConsistencyCheck(const MergeConfig& config, const SessionMap& sessions, const CloudRequests& requests,
                   CandidateVerifier& verifier, AlignmentBook& book)
      : config_(config), sessions_(sessions), requests_(requests), verifier_(verifier), book_(book) {}

  /// Judges the pairs of sessions that alignments would bring together. Pairs that agree become alignments themselves.
  /// Obtainable clouds are requested first, for one pair at a time.
  void look_at_contacts(const Attempt& attempt);

  /// What is known of two sessions at this placement: nullopt if they do not come near each other there, unknown if
  /// they were not judged there yet.
  std::optional<Contact> known_contact(const ImpliedPlacement& placement);

  /// Describes how two sessions contradict each other.
  Objection objection(const std::pair<SessionId, SessionId>& pair) const;

  void forget(SessionId id);

 private:
  /// The result for two sessions at one placement.
  struct SeenContact {
    Pose T_a_b = Pose::Identity();
    std::size_t keyframes = 0;  // of both, whose clouds were used
    bool whole = false;         // both had ended
    Contact contact = Contact::none;
    Judgement judgement = {};
    double violation = 0;   // at the worst place, or of the overlap; the lesser of what was implied and registered
    bool recorded = false;  // as an alignment, once both were in one component
  };

  void look_while_news(AlignmentBook::Waiting waiting, const Attempt& attempt);
  bool meet(const ImpliedPlacement& placement) const;
  SeenContact* seen(const ImpliedPlacement& placement);
  bool look_at(const ImpliedPlacement& placement, const Attempt& attempt);
  SeenContact judged(const ImpliedPlacement& placement, const OrderedPair& pair, const Case& at,
                     CloudSource& clouds) const;
  bool record_agreeing(const MergeResult& merged, AttemptReport& report);

  const MergeConfig config_;
  const SessionMap& sessions_;
  const CloudRequests& requests_;
  CandidateVerifier& verifier_;
  AlignmentBook& book_;
  std::map<std::pair<SessionId, SessionId>, std::vector<SeenContact>> contacts_;  // the latest placements of each pair
};

}  // namespace headframe
