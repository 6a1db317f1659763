#pragma once
// Where could two sessions lie on each other? One list from several sources, for the registration to judge: best first
// by the walls' score times the descriptors' agreement.

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/place/descriptor_agreement.hpp"
#include "server/place/descriptor_index.hpp"
#include "server/place/descriptor_matches.hpp"
#include "server/place/leads.hpp"
#include "server/place/session_walls.hpp"
#include "server/support/lru_map.hpp"

namespace headframe {

struct Hypothesis {
  Pose T_a_b = Pose::Identity();  // 4 degrees of freedom: both frames have z along gravity
  double score = 0;               // of a piece of b's walls laid on a's: comparable whatever the source
  Eigen::Vector3d place_b = Eigen::Vector3d::Zero();  // the middle of b's walls that met a's, in b's frame
  Agreement descriptors = {};                         // along both paths
  double promise = 0;                                 // score, weighed by the descriptors' agreement
  ProposalSource source = ProposalSource::walls;
};

/// A session as the finder sees it.
struct SessionView {
  SessionId id = 0;
  std::span<const Keyframe> keyframes;
  bool complete = false;
  FamilyId family = {};     // of its descriptors: those of different families are not compared
  bool asks_where = false;  // its robot waits for what is found
};

/// What was found for a pair of sessions, best first. The version changes with every new search.
struct Found {
  std::size_t version = 0;
  std::vector<Hypothesis> hypotheses;
  double path_a_m = 0, path_b_m = 0;  // of the sessions when it was searched
};

/// Finds hypotheses for pairs of sessions, and remembers what it drew and found: a pair is searched again when one of
/// both has grown by news_m (asked_news_m), or at all when it is complete now. Not thread safe.
class HypothesisFinder {
 public:
  struct Config {
    LeadSeats seats = {};
    double news_m = 15, asked_news_m = 2;  // the second where a robot asks where it is
    std::size_t walls_bytes = 64000000;    // drawn walls that are kept: the least recently used go first
    int threads = 1;
  };
  explicit HypothesisFinder(const Config& config) : config_(config) {}

  /// New searches until the next call of allow().
  void allow(std::size_t searches) { allowed_ = searches; }

  /// Null when it would take a search and none is allowed any more. The pointer holds until the next call. `matches` is
  /// called for a new search only.
  const Found* find(const SessionView& a, const SessionView& b,
                    const std::function<std::vector<MatchedPair>()>& matches);
  /// Where a session lies on itself, where it is and elsewhere. Searched anew at each call; not counted by allow().
  const Found* find_within(const SessionView& session);
  /// Its keyframes will lie elsewhere: whatever was drawn and found of it is so no more.
  void forget(SessionId session);

 private:
  std::shared_ptr<const SessionWalls> walls(const SessionView& session);
  std::vector<Hypothesis> search(const SessionView& a, const SessionView& b, const std::vector<MatchedPair>& matches,
                                 const DescriptorAgreement& agreement, const LeadSeats& seats);

  Config config_;
  std::size_t allowed_ = std::numeric_limits<std::size_t>::max();
  LruMap<SessionId, std::shared_ptr<const SessionWalls>> walls_;
  std::size_t walls_bytes_ = 0;
  std::map<std::pair<SessionId, SessionId>, Found> found_;
};

}  // namespace headframe
