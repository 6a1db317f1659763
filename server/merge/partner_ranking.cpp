#include "server/merge/partner_ranking.hpp"

#include <algorithm>

namespace headframe {
namespace {

constexpr std::size_t exact_up_to = 20000;   // keyframes of a family; FLANN beyond
constexpr std::size_t asked_of_index = 20;   // nearest keyframes of any session, to see who looks alike ...
constexpr std::size_t keyframes_asked = 30;  // ... for so many keyframes spread over a session

/// All keyframes of these sessions but the last of `newest`, which is added next.
void add_all(DescriptorIndex& index, const FamilyId& family, std::size_t q_size, const SessionMap& sessions,
             SessionId newest) {
  for (const auto& [id, session] : sessions.all()) {
    if (session.family != family) continue;
    const std::size_t count = session.keyframes.size() - (id == newest ? 1 : 0);
    for (std::size_t i = 0; i < count; ++i)
      if (const Keyframe& k = session.keyframes[i]; k.descriptor.q.size() == q_size)
        index.add({id, k.sequence}, k.descriptor.q);
  }
}

}  // namespace

void PartnerRanking::add(SessionId id, const Keyframe& keyframe, const SessionMap& sessions) {
  const FamilyId& family = sessions.at(id).family;
  const auto& q = keyframe.descriptor.q;
  if (q.empty()) return;
  auto& index = indices_[{family, q.size()}];
  if (!index) index = make_exact_index(q.size());
  if (index->size() == exact_up_to) {
    index = make_flann_index(q.size());
    add_all(*index, family, q.size(), sessions, id);
  }
  index->add({id, keyframe.sequence}, q);
}

std::vector<SessionId> PartnerRanking::rank(SessionId id, const SessionMap& sessions) const {
  const Session& self = sessions.at(id);
  std::map<SessionId, int> alike;
  for (const auto& [other, session] : sessions.all())
    if (other != id) alike[other] = 0;
  if (alike.size() > 1) {
    const std::size_t step = std::max<std::size_t>(1, self.keyframes.size() / keyframes_asked);
    for (std::size_t i = 0; i < self.keyframes.size(); i += step) {
      const auto& q = self.keyframes[i].descriptor.q;
      const auto index = indices_.find({self.family, q.size()});
      if (index == indices_.end()) continue;
      for (const PlaceNeighbour& n : index->second->nearest(q, asked_of_index))
        if (const auto found = alike.find(n.keyframe.session); found != alike.end()) ++found->second;
    }
  }
  std::vector<SessionId> order;
  order.reserve(alike.size());
  for (const auto& [other, count] : alike) order.push_back(other);
  std::stable_sort(order.begin(), order.end(), [&](SessionId x, SessionId y) { return alike.at(x) > alike.at(y); });
  return order;
}

}  // namespace headframe
