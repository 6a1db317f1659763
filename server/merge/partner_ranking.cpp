#include "server/merge/partner_ranking.hpp"

#include <algorithm>
#include <set>

#include "server/place/wall_signature.hpp"

namespace headframe {
namespace {

constexpr std::size_t asked_of_index = 200;  // nearest keyframes that are looked up ...
constexpr std::size_t keyframes_asked = 48;  // ... for each of this many keyframes spread over a session

using Vector = std::vector<float>;

/// Calls `ask` for keyframes spread evenly over the session.
template <class Ask>
void for_some_keyframes(const Session& session, Ask ask) {
  const std::size_t step = std::max<std::size_t>(1, session.keyframes.size() / keyframes_asked);
  for (std::size_t i = 0; i < session.keyframes.size(); i += step) ask(session.keyframes[i]);
}

/// Each query gives 1 vote to the session with the most similar keyframe, 1/2 to the next, then 1/3 and so on.
template <class Votes, class MayVote>
void vote(const DescriptorIndex& index, const std::vector<Vector>& asked, int threads, MayVote may_vote, Votes& votes) {
  const std::vector<std::span<const float>> queries(asked.begin(), asked.end());
  for (const auto& neighbours : index.nearest_of_each(queries, asked_of_index, threads)) {
    std::set<SessionId> met;
    for (const PlaceNeighbour& n : neighbours)
      if (may_vote(n.keyframe.session) && met.insert(n.keyframe.session).second)
        votes[n.keyframe.session] += 1 / static_cast<double>(met.size());
  }
}

}  // namespace

void PartnerRanking::add(SessionId id, const Keyframe& keyframe, const SessionMap& sessions) {
  ++changes_;
  const Session& session = sessions.at(id);
  const auto& q = keyframe.descriptor.q;
  std::uint64_t& last = places_of_[{session.site, id}];
  if (keyframe.sequence <= last || q.empty()) return;
  const Kind kind{session.site, session.family, q.size()};
  auto& index = places_[kind];
  if (!index) index = make_exact_index(q.size());
  if (index->size() == exact_up_to_) {
    index = make_flann_index(q.size());
    add_all(*index, kind, sessions);
  }
  last = keyframe.sequence;
  index->add({id, keyframe.sequence}, q);
}

/// Adds all keyframes that were added one by one before.
void PartnerRanking::add_all(DescriptorIndex& index, const Kind& kind, const SessionMap& sessions) const {
  for (const auto& [id, session] : sessions.all())
    for (const Keyframe& k : session.keyframes)
      if (Kind{session.site, session.family, k.descriptor.q.size()} == kind &&
          k.sequence <= places_of_.at({session.site, id}))
        index.add({id, k.sequence}, k.descriptor.q);
}

/// Entries in the earlier site's indices are ignored there, and count again if the session returns.
void PartnerRanking::take_to_site(SessionId id, const SessionMap& sessions) {
  ++changes_;
  for (const Keyframe& keyframe : sessions.at(id).keyframes) add(id, keyframe, sessions);
}

PartnerRanking::Votes PartnerRanking::votes_by_places(SessionId id, const SessionMap& sessions) const {
  const Session& self = sessions.at(id);
  std::map<std::size_t, std::vector<Vector>> asked;  // by length
  for_some_keyframes(self, [&](const Keyframe& k) { asked[k.descriptor.q.size()].push_back(k.descriptor.q); });
  const auto may_vote = [&](SessionId other) {
    return other != id && sessions.contains(other) && sessions.at_one_site(id, other);
  };
  Votes out;
  for (const auto& [size, vectors] : asked)
    if (const auto index = places_.find({self.site, self.family, size}); index != places_.end())
      vote(*index->second, vectors, config_.threads, may_vote, out);
  return out;
}

PartnerRanking::Votes PartnerRanking::votes_by_walls(SessionId id, const SessionMap& sessions) {
  const Session& self = sessions.at(id);
  take_in_walls(self.site, sessions);
  std::vector<Vector> asked;
  for_some_keyframes(self, [&](const Keyframe& k) {
    if (auto signature = wall_signature(k.walls)) asked.push_back(std::move(*signature));
  });
  const auto may_vote = [&](SessionId other) {
    return sessions.contains(other) && sessions.at_one_site(id, other) && sessions.at(other).family != self.family;
  };
  Votes out;
  vote(*walls_.at(self.site), asked, config_.threads, may_vote, out);
  return out;
}

/// Adds the keyframes that came since the last call.
void PartnerRanking::take_in_walls(const std::string& site, const SessionMap& sessions) {
  auto& walls = walls_[site];
  if (!walls) walls = make_exact_index(wall_signature_size);
  for (const auto& [id, session] : sessions.all())
    if (session.site == site)
      for (std::size_t& i = walls_of_[{site, id}]; i < session.keyframes.size(); ++i)
        if (const auto signature = wall_signature(session.keyframes[i].walls))
          walls->add({id, session.keyframes[i].sequence}, *signature);
}

std::vector<SessionId> PartnerRanking::rank(SessionId id, const SessionMap& sessions) {
  if (last_.id != id || last_.sessions != sessions.all().size() || last_.changes != changes_)
    last_ = {id, sessions.all().size(), changes_, ranked(id, sessions)};
  return last_.order;
}

std::vector<SessionId> PartnerRanking::ranked(SessionId id, const SessionMap& sessions) {
  const auto partners = static_cast<std::size_t>(config_.partners);
  const Session& self = sessions.at(id);
  std::vector<SessionId> kin, strangers;
  for (const auto& [other, session] : sessions.all())
    if (other != id && session.site == self.site) (session.family == self.family ? kin : strangers).push_back(other);
  const bool all = kin.size() + strangers.size() <= partners;
  std::vector<SessionId> order;
  for (const bool of_family : {true, false}) {
    std::vector<SessionId>& group = of_family ? kin : strangers;
    if (group.size() > 1) {
      Votes votes = of_family ? votes_by_places(id, sessions) : votes_by_walls(id, sessions);
      std::stable_sort(group.begin(), group.end(), [&](SessionId x, SessionId y) { return votes[x] > votes[y]; });
    }
    const std::size_t seats = (of_family ? 4 : 2) * partners;
    if (!all && group.size() > seats) group.resize(seats);
    order.insert(order.end(), group.begin(), group.end());
  }
  return order;
}

}  // namespace headframe
