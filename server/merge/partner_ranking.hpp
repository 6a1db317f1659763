#pragma once

#include <map>
#include <memory>

#include "server/merge/session_map.hpp"
#include "server/place/descriptor_index.hpp"

namespace headframe {

/// Which sessions look like one: the place index over the whole database, by family and length of q, for two robots may
/// call different vectors by one name. Compares with every keyframe up to 20000 of a family, and asks FLANN's trees
/// beyond. Not thread safe.
class PartnerRanking {
 public:
  /// A keyframe of the session as it was taken in; `sessions` holds it already.
  void add(SessionId id, const Keyframe& keyframe, const SessionMap& sessions);

  /// All other sessions, those whose descriptors look most alike first. Of another family nothing is known.
  std::vector<SessionId> rank(SessionId id, const SessionMap& sessions) const;

 private:
  std::map<std::pair<FamilyId, std::size_t>, std::unique_ptr<DescriptorIndex>> indices_;
};

}  // namespace headframe
