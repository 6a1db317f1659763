#pragma once

#include <map>
#include <memory>

#include "server/merge/session_map.hpp"
#include "server/place/descriptor_index.hpp"

namespace headframe {

/// Ranks the sessions of a site by how promising a search with a given session is, with one place index for each site.
/// Sessions of the same descriptor family vote by their place vectors (by family and length of q, because two robots
/// may use one name for different vectors), sessions of other families by their wall profiles. Compares all keyframes
/// up to exact_up_to of a family, beyond that it uses FLANN's trees. Not thread safe.
class PartnerRanking {
 public:
  explicit PartnerRanking(const MergeConfig& config, std::size_t exact_up_to = 500000)
      : config_(config), exact_up_to_(exact_up_to) {}

  /// Adds a keyframe that `sessions` already holds. Adding a keyframe again has no effect.
  void add(SessionId id, const Keyframe& keyframe, const SessionMap& sessions);
  /// The session was moved to another site.
  void take_to_site(SessionId id, const SessionMap& sessions);

  /// The sessions whose places look most like those of this one, best first: at most four times MergeConfig::partners
  /// of its own family, then at most twice that number of other families. All of them if the site has no more than
  /// `partners` others. Remembers the last answer until a session comes, grows, moves or goes.
  std::vector<SessionId> rank(SessionId id, const SessionMap& sessions);

 private:
  using Votes = std::map<SessionId, double>;
  using OfSite = std::pair<std::string, SessionId>;
  struct Kind {  // of place vectors that are compared
    std::string site;
    FamilyId family;
    std::size_t q_size = 0;
    auto operator<=>(const Kind&) const = default;
  };
  Votes votes_by_places(SessionId id, const SessionMap& sessions) const;
  Votes votes_by_walls(SessionId id, const SessionMap& sessions);
  std::vector<SessionId> ranked(SessionId id, const SessionMap& sessions);
  void take_in_walls(const std::string& site, const SessionMap& sessions);
  void add_all(DescriptorIndex& index, const Kind& kind, const SessionMap& sessions) const;

  /// An answer, and what there was when it was given.
  struct Answer {
    SessionId id = 0;
    std::size_t sessions = 0;
    std::uint64_t changes = 0;
    std::vector<SessionId> order;
  };

  const MergeConfig config_;
  const std::size_t exact_up_to_;
  std::map<Kind, std::unique_ptr<DescriptorIndex>> places_;
  std::map<OfSite, std::uint64_t> places_of_;                      // the last keyframe of each session that was added
  std::map<std::string, std::unique_ptr<DescriptorIndex>> walls_;  // by site; created when first needed
  std::map<OfSite, std::size_t> walls_of_;                         // how many keyframes of each session were taken in
  std::uint64_t changes_ = 0;                                      // keyframes added, and sessions moved
  Answer last_;
};

}  // namespace headframe
