#include "server/atlas/dependents.hpp"

#include <map>
#include <utility>

namespace headframe {

Dependents dependents_of(SessionId session, const Atlas& atlas, std::span<const Alignment> alignments) {
  Dependents out;
  const auto component = std::find_if(atlas.components.begin(), atlas.components.end(),
                                      [&](const Component& c) { return placement_in(c, session) != nullptr; });
  if (component == atlas.components.end()) return out;
  out.is_anchor = component->id == session && component->placements.size() > 1;
  std::map<SessionId, std::vector<SessionId>> beside;
  for (const Alignment& k : alignments) {
    if (k.state != AlignmentState::published || !placement_in(*component, k.a)) continue;
    beside[k.a].push_back(k.b);
    beside[k.b].push_back(k.a);
  }
  out.merged_with = beside[session];
  std::sort(out.merged_with.begin(), out.merged_with.end());
  std::map<SessionId, bool> reached{{session, true}};
  for (const Placement& placement : component->placements) {
    if (reached[placement.session]) continue;
    std::vector<SessionId> part{placement.session};
    reached[placement.session] = true;
    for (std::size_t i = 0; i < part.size(); ++i)
      for (const SessionId next : beside[part[i]])
        if (!std::exchange(reached[next], true)) part.push_back(next);
    std::sort(part.begin(), part.end());
    out.parts.push_back(std::move(part));
  }
  return out;
}

}  // namespace headframe
