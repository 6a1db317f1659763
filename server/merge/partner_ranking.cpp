#include "server/merge/partner_ranking.hpp"

#include <algorithm>
#include <set>

#include "server/place/wall_signature.hpp"

namespace headframe {
namespace {

constexpr std::size_t asked_of_index = 200;  // nearest keyframes of any session, to see whose places look alike ...
constexpr std::size_t keyframes_asked = 48;  // ... for so many keyframes spread over a session

const FamilyId no_family{};  // of wall signatures

using Vector = std::vector<float>;

/// The vector of a keyframe by which it is found: its place vector, or its wall signature.
std::optional<Vector> vector_of(const Keyframe& keyframe, bool of_family) {
  if (!of_family) return wall_signature(keyframe.walls);
  return keyframe.descriptor.q.empty() ? std::nullopt : std::optional(keyframe.descriptor.q);
}

/// All keyframes of the sessions that belong into the index, but for the last of `newest`, which is added next.
void add_all(DescriptorIndex& index, const FamilyId& family, std::size_t size, const SessionMap& sessions,
             SessionId newest) {
  const bool of_family = family != no_family;
  for (const auto& [id, session] : sessions.all()) {
    if (of_family && session.family != family) continue;
    const std::size_t count = session.keyframes.size() - (id == newest ? 1 : 0);
    for (std::size_t i = 0; i < count; ++i)
      if (const auto vector = vector_of(session.keyframes[i], of_family); vector && vector->size() == size)
        index.add({id, session.keyframes[i].sequence}, *vector);
  }
}

}  // namespace

void PartnerRanking::add(SessionId id, const Keyframe& keyframe, const SessionMap& sessions) {
  for (const bool of_family : {true, false}) {
    const auto vector = vector_of(keyframe, of_family);
    if (!vector) continue;
    const FamilyId& family = of_family ? sessions.at(id).family : no_family;
    auto& index = indices_[{family, vector->size()}];
    if (!index) index = make_exact_index(vector->size());
    if (index->size() == exact_up_to_) {
      index = make_flann_index(vector->size());
      add_all(*index, family, vector->size(), sessions, id);
    }
    index->add({id, keyframe.sequence}, *vector);
  }
}

/// Each keyframe asked gives its most alike session 1, the next 1/2, then 1/3 and so on.
PartnerRanking::Votes PartnerRanking::votes(SessionId id, const SessionMap& sessions, bool of_family) const {
  const Session& self = sessions.at(id);
  std::vector<Vector> asked;
  const std::size_t step = std::max<std::size_t>(1, self.keyframes.size() / keyframes_asked);
  for (std::size_t i = 0; i < self.keyframes.size(); i += step)
    if (auto vector = vector_of(self.keyframes[i], of_family)) asked.push_back(std::move(*vector));
  Votes out;
  for (const auto& [key, index] : indices_) {
    if (key.first != (of_family ? self.family : no_family)) continue;
    std::vector<std::span<const float>> queries;
    for (const Vector& vector : asked)
      if (vector.size() == key.second) queries.emplace_back(vector);
    for (const auto& neighbours : index->nearest_of_each(queries, asked_of_index, config_.threads)) {
      std::set<SessionId> met;
      for (const PlaceNeighbour& n : neighbours) {
        const SessionId other = n.keyframe.session;
        if (other == id || !sessions.contains(other) || (sessions.at(other).family == self.family) != of_family)
          continue;
        if (met.insert(other).second) out[other] += 1 / static_cast<double>(met.size());
      }
    }
  }
  return out;
}

std::vector<SessionId> PartnerRanking::rank(SessionId id, const SessionMap& sessions) const {
  const auto partners = static_cast<std::size_t>(config_.partners);
  const bool all = sessions.all().size() <= partners + 1;
  std::vector<SessionId> order;
  for (const bool of_family : {true, false}) {
    std::vector<SessionId> group;
    for (const auto& [other, session] : sessions.all())
      if (other != id && (session.family == sessions.at(id).family) == of_family) group.push_back(other);
    if (group.empty()) continue;
    if (group.size() > 1) {
      Votes votes = this->votes(id, sessions, of_family);
      std::stable_sort(group.begin(), group.end(), [&](SessionId x, SessionId y) { return votes[x] > votes[y]; });
    }
    const std::size_t seats = (of_family ? 4 : 2) * partners;
    if (!all && group.size() > seats) group.resize(seats);
    order.insert(order.end(), group.begin(), group.end());
  }
  return order;
}

}  // namespace headframe
