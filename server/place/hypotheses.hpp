#pragma once
// Where could two sessions overlap? One list of hypotheses from several sources, for registration to judge. Best first,
// by the walls' score times the similarity of the descriptors.

#include <limits>
#include <map>
#include <memory>
#include <span>
#include <utility>
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
  double score = 0;               // of a piece of b's walls on a's walls; comparable between sources
  Eigen::Vector3d place_b = Eigen::Vector3d::Zero();  // the middle of b's walls that match a's, in b's frame
  Agreement descriptors = {};                         // along both paths
  double promise = 0;                                 // score, weighted by the descriptors' similarity
  double contradiction = 0;                           // of the walls (WallFit::contradiction)
  ProposalSource source = ProposalSource::walls;
};

/// What the finder knows of a session.
struct SessionView {
  SessionId id = 0;
  std::span<const Keyframe> keyframes;
  bool complete = false;
  FamilyId family = {};     // of its descriptors; different families are not compared
  bool asks_where = false;  // its robot asks where it is
};

/// Hypotheses for a pair of sessions, best first. The version changes with every new search.
struct Found {
  std::size_t version = 0;
  std::vector<Hypothesis> hypotheses;
  double path_a_m = 0, path_b_m = 0;  // of the sessions when it was searched
};

/// Finds hypotheses for pairs of sessions, and remembers wall maps and results. A pair is searched again when one of
/// the two has grown by news_m (asked_news_m while a robot asks where it is), or by any amount if it is complete now.
/// Not thread safe.
class HypothesisFinder {
 public:
  struct Config {
    LeadSeats seats = {};
    double news_m = 15, asked_news_m = 2;  // growth that causes a new search; the second if a robot asks where it is
    std::size_t walls_bytes = 64000000;    // memory for wall maps; the least recently used are discarded first
    int threads = 1;
  };
  explicit HypothesisFinder(const Config& config) : config_(config) {}

  /// Allows this many new searches until the next call.
  void allow(std::size_t searches) { allowed_ = searches; }
  bool may_search() const { return allowed_ > 0; }

  /// Whether find() would search the pair anew now, or would if that were allowed.
  bool needs_search(const SessionView& a, const SessionView& b) const;
  /// The hypotheses of a new search, which depend on nothing but the two sessions. Does not count against allow(), and
  /// find() does not learn of them.
  std::vector<Hypothesis> search_apart(const SessionView& a, const SessionView& b);
  /// As find(), for a pair that needs a search whose hypotheses are known: search_apart() of the same sessions.
  const Found* take(const SessionView& a, const SessionView& b, std::vector<Hypothesis> hypotheses);

  /// Returns null if a new search would be needed and none is allowed any more. The pointer is valid until the next
  /// call.
  const Found* find(const SessionView& a, const SessionView& b);
  /// For each pair, the most that its best hypotheses promise: Hypothesis::promise times (2 s)^2, where s is how
  /// similar the descriptors are (0.5 if none were compared), because between pairs they say more than between
  /// placements of one pair. 0 without any hypothesis. A search with few seats and a third of the rotations, of several
  /// pairs at once. Does not count against allow(), and find() does not learn of it.
  std::vector<double> promises(std::span<const std::pair<SessionView, SessionView>> pairs);
  /// Whether the session has grown enough for a new search since its path was so long.
  bool has_news(const SessionView& session, double path_then_m) const;

  /// Placements of a session on itself, including the true one. Searched again at each call; does not count against
  /// allow().
  const Found* find_within(const SessionView& session);
  /// The session's keyframes are about to move: discards its wall maps and results.
  void forget(SessionId session);

 private:
  /// The walls of a session, and what they were drawn from.
  struct Drawn {
    std::shared_ptr<const SessionWalls> walls;
    std::size_t keyframes = 0, with_walls = 0;
  };
  using WallsPtr = std::shared_ptr<const SessionWalls>;
  std::vector<WallsPtr> walls(std::span<const SessionView> sessions);
  std::vector<Hypothesis> search(const SessionView& a, const SessionView& b, const SessionWalls& walls_a,
                                 const SessionWalls& walls_b, const std::vector<MatchedPair>& matches,
                                 const DescriptorAgreement& agreement, const LeadSeats& seats) const;
  std::vector<Hypothesis> search(const SessionView& a, const SessionView& b, const SessionWalls& walls_a,
                                 const SessionWalls& walls_b, const LeadSeats& seats) const;

  Config config_;
  std::size_t allowed_ = std::numeric_limits<std::size_t>::max();
  LruMap<SessionId, Drawn> walls_;
  std::size_t walls_bytes_ = 0;
  std::map<std::pair<SessionId, SessionId>, Found> found_;
};

}  // namespace headframe
