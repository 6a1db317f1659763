#include "server/merge/partner_promise.hpp"

#include <algorithm>

#include "server/merge/pair_search.hpp"

namespace headframe {
namespace {

constexpr int at_once = 8;      // searches in one call, which take some quarter of a second
constexpr double share = 0.2;   // of the best partner's promise
constexpr double enough = 100;  // walls in cells: nine of ten pairs that share 20 to 40 m promise about as much

struct Promising {
  SessionId id = 0;
  double promise = 0;
};

/// The most promising first; of equal ones, the one that was ranked higher.
void append_best(std::vector<Promising> list, std::vector<SessionId>& out) {
  std::stable_sort(list.begin(), list.end(), [](const auto& p, const auto& q) { return p.promise > q.promise; });
  for (const Promising& p : list)
    if (p.promise >= std::min(enough, share * list.front().promise)) out.push_back(p.id);
}

}  // namespace

std::optional<double> PartnerPromise::promise(SessionId id, SessionId other, int& searches) {
  const OrderedPair pair = sessions_.ordered(id, other);
  const Session &session_a = sessions_.at(pair.a), &session_b = sessions_.at(pair.b);
  const SessionView a = PairSearch::view(pair.a, session_a), b = PairSearch::view(pair.b, session_b);
  const auto key = std::minmax(id, other);
  const SessionView &first = pair.a == key.first ? a : b, &second = pair.a == key.first ? b : a;
  const auto known = known_.find(key);
  if (known != known_.end() && !finder_.has_news(first, known->second.first_path_m) &&
      !finder_.has_news(second, known->second.second_path_m))
    return known->second.promise;
  if (searches-- <= 0) return std::nullopt;
  const double found = finder_.promise(
      a, b, [&] { return match_descriptors(session_a.keyframes, session_b.keyframes, config_.threads); });
  known_[key] = {found, path_m(first.keyframes), path_m(second.keyframes)};
  return found;
}

std::optional<std::vector<SessionId>> PartnerPromise::choose(SessionId id, const std::vector<SessionId>& ranked) {
  const auto most = 2 * static_cast<std::size_t>(config_.partners);
  std::vector<Promising> same_family, other_families;
  int searches = at_once;
  for (const SessionId other : ranked) {
    auto& list = sessions_.at(other).family == sessions_.at(id).family ? same_family : other_families;
    if (list.size() == most || !sessions_.worth_a_look(sessions_.ordered(id, other))) continue;
    const auto found = promise(id, other, searches);
    if (!found) return std::nullopt;
    list.push_back({other, *found});
  }
  std::vector<SessionId> out;
  append_best(std::move(same_family), out);
  append_best(std::move(other_families), out);
  return out;
}

}  // namespace headframe
