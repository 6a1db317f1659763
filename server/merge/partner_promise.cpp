#include "server/merge/partner_promise.hpp"

#include <algorithm>

#include "server/merge/pair_search.hpp"

namespace headframe {
namespace {

constexpr std::size_t at_once = 8;  // searches in one call, which take some tenth of a second
constexpr double least = 20;        // of 1306 pairs that shared 20 m of path, all but two promised 30 or more
constexpr double places = 8;  // of two that promise the same, the 9th of the ranking counts half as much as the first

}  // namespace

bool PartnerPromise::is_known(SessionId id, SessionId other) const {
  const auto key = std::minmax(id, other);
  const auto known = known_.find(key);
  const auto has_news = [&](SessionId session, double path_then_m) {
    return finder_.has_news(PairSearch::view(session, sessions_.at(session)), path_then_m);
  };
  return known != known_.end() && !has_news(key.first, known->second.first_path_m) &&
         !has_news(key.second, known->second.second_path_m);
}

void PartnerPromise::search(SessionId id, const std::vector<SessionId>& others) {
  const auto view = [&](SessionId session) { return PairSearch::view(session, sessions_.at(session)); };
  std::vector<std::pair<SessionView, SessionView>> pairs;
  for (const SessionId other : others) {
    const OrderedPair pair = sessions_.ordered(id, other);
    pairs.emplace_back(view(pair.a), view(pair.b));
  }
  const std::vector<double> promises = finder_.promises(pairs);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto key = std::minmax(id, others[i]);
    known_[key] = {promises[i], path_m(sessions_.at(key.first).keyframes), path_m(sessions_.at(key.second).keyframes)};
  }
}

std::optional<std::vector<SessionId>> PartnerPromise::choose(SessionId id, const std::vector<SessionId>& ranked) {
  const auto most = 2 * static_cast<std::size_t>(config_.partners);
  std::vector<SessionId> same, others;  // of the session's descriptor family, and of others
  std::vector<SessionId> unknown;
  for (const SessionId other : ranked) {
    std::vector<SessionId>& family = sessions_.at(other).family == sessions_.at(id).family ? same : others;
    if (family.size() == most || !sessions_.worth_a_look(sessions_.ordered(id, other))) continue;
    family.push_back(other);
    if (!is_known(id, other)) unknown.push_back(other);
  }
  const bool all = unknown.size() <= at_once;
  if (!all) unknown.resize(at_once);
  search(id, unknown);
  if (!all) return std::nullopt;
  std::vector<SessionId> out;
  for (const auto& family : {same, others}) append_promising(id, family, out);
  return out;
}

/// The most promising first.
void PartnerPromise::append_promising(SessionId id, const std::vector<SessionId>& compared,
                                      std::vector<SessionId>& out) const {
  std::vector<std::pair<double, SessionId>> partners;  // minus what it is worth
  for (std::size_t i = 0; i < compared.size(); ++i)
    if (const double promise = known_.at(std::minmax(id, compared[i])).promise; promise >= least)
      partners.emplace_back(-promise / (places + static_cast<double>(i)), compared[i]);
  std::stable_sort(partners.begin(), partners.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
  for (const auto& [worth, partner] : partners) out.push_back(partner);
}

}  // namespace headframe
