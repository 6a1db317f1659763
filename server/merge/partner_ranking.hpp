#pragma once

#include <map>
#include <memory>

#include "server/merge/session_map.hpp"
#include "server/place/descriptor_index.hpp"

namespace headframe {

/// Which sessions of its site are worth a search with one: a place index for each site. Sessions of one family vote by
/// their place vectors (by family and length of q, for two robots may call different vectors by one name), sessions of
/// other families by their wall profiles. Compares with every keyframe up to exact_up_to of a family, and asks FLANN's
/// trees beyond. Not thread safe.
class PartnerRanking {
 public:
  explicit PartnerRanking(const MergeConfig& config, std::size_t exact_up_to = 500000)
      : config_(config), exact_up_to_(exact_up_to) {}

  /// A keyframe of the session as it was taken in; `sessions` holds it already. One that comes again is known.
  void add(SessionId id, const Keyframe& keyframe, const SessionMap& sessions);
  /// Its site is another one since.
  void take_to_site(SessionId id, const SessionMap& sessions);

  /// The sessions whose places look most like those of this one, best first: at most four times MergeConfig::partners
  /// of its family, then at most half as many of others. While there are no more than `partners` others, all of them.
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
  void take_in_walls(const std::string& site, const SessionMap& sessions);
  void add_all(DescriptorIndex& index, const Kind& kind, const SessionMap& sessions) const;

  const MergeConfig config_;
  const std::size_t exact_up_to_;
  std::map<Kind, std::unique_ptr<DescriptorIndex>> places_;
  std::map<OfSite, std::uint64_t> places_of_;                      // the last keyframe of each session that was added
  std::map<std::string, std::unique_ptr<DescriptorIndex>> walls_;  // by site; none while all there are of one family
  std::map<OfSite, std::size_t> walls_of_;                         // keyframes of each session that are in it
};

}  // namespace headframe
