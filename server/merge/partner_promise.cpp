#include "server/merge/partner_promise.hpp"

#include <algorithm>

#include "server/merge/pair_search.hpp"

namespace headframe {
namespace {

constexpr int at_once = 8;    // searches in one call, which take some quarter of a second
constexpr double least = 20;  // walls in cells; of 469 pairs that shared 20 m of path, the least promised 33
constexpr double places = 8;  // of two that promise the same, the 9th of the ranking counts half as much as the first

struct Partner {
  SessionId id = 0;
  double worth = 0;
};

/// The best first.
void append(std::vector<Partner> list, std::vector<SessionId>& out) {
  std::stable_sort(list.begin(), list.end(), [](const auto& p, const auto& q) { return p.worth > q.worth; });
  for (const Partner& p : list) out.push_back(p.id);
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
  struct Family {
    std::vector<Partner> partners;
    std::size_t compared = 0;
  } same, others;
  int searches = at_once;
  for (const SessionId other : ranked) {
    Family& family = sessions_.at(other).family == sessions_.at(id).family ? same : others;
    if (family.compared == most || !sessions_.worth_a_look(sessions_.ordered(id, other))) continue;
    const auto found = promise(id, other, searches);
    if (!found) return std::nullopt;
    if (*found >= least) family.partners.push_back({other, *found / (places + static_cast<double>(family.compared))});
    ++family.compared;
  }
  std::vector<SessionId> out;
  append(std::move(same.partners), out);
  append(std::move(others.partners), out);
  return out;
}

}  // namespace headframe
