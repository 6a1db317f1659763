#pragma once
// Sessions that others would bring together: before maps merge, each pair of sessions that would come to lie on each
// other is looked at where it meets. Exact copies of a tunnel pass every test of their own; what lies around them in a
// third session's map tells them apart.

#include "server/merge/alignment_book.hpp"
#include "server/merge/candidate_verifier.hpp"

namespace headframe {

/// Two sessions as they would lie if they were merged by way of others.
struct ImpliedPlacement {
  SessionId a = 0, b = 0;  // a < b
  Pose T_a_b = Pose::Identity();
};

/// Owns what was found where sessions meet. Not thread safe.
class ConsistencyCheck {
 public:
  ConsistencyCheck(const MergeConfig& config, const SessionMap& sessions, const CloudRequests& requests,
                   CandidateVerifier& verifier, AlignmentBook& book)
      : config_(config), sessions_(sessions), requests_(requests), verifier_(verifier), book_(book) {}

  /// Looks where sessions that alignments would bring together meet. Those that agree become alignments themselves.
  /// Clouds that can be had are asked for first, those of one contact at a time.
  void look_at_contacts(const Attempt& attempt);

  /// What is known of two sessions where others would put them: nothing where they do not come near each other there,
  /// unknown where nobody has looked.
  std::optional<Contact> known_contact(const ImpliedPlacement& placement);

  /// What two sessions that contradict each other say.
  Objection objection(const std::pair<SessionId, SessionId>& pair) const;

  void forget(SessionId id);

 private:
  /// What was found where two sessions without an alignment of their own meet.
  struct SeenContact {
    Pose T_a_b = Pose::Identity();
    std::size_t keyframes = 0;  // of both, that spoke
    Contact contact = Contact::none;
    Judgement judgement;
    bool recorded = false;  // as an alignment, once both were in one component
  };

  void look_while_news(AlignmentBook::Waiting waiting, const Attempt& attempt);
  bool meet(const ImpliedPlacement& placement) const;
  SeenContact* seen(const ImpliedPlacement& placement);
  bool look_at(const ImpliedPlacement& placement, const Attempt& attempt);
  SeenContact judged(const ImpliedPlacement& placement, const OrderedPair& pair, const Case& at,
                     CloudSource& clouds) const;
  bool record_agreeing(const MergeResult& merged, AttemptReport& report);
  static double violation_of(const SeenContact& seen);

  const MergeConfig config_;
  const SessionMap& sessions_;
  const CloudRequests& requests_;
  CandidateVerifier& verifier_;
  AlignmentBook& book_;
  std::map<std::pair<SessionId, SessionId>, std::vector<SeenContact>> contacts_;  // the latest placements of each pair
};

}  // namespace headframe
