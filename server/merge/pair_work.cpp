#include "server/merge/pair_work.hpp"

#include <algorithm>

namespace headframe {

void PairWork::begin() {
  digests_.emplace();
  announced_.clear();
  if (open_.size() > most_open) open_.clear();  // of sessions that have changed since: they are searched here
  helped_ = false;
}

bool PairWork::helpers_came() {
  if (helped_ || !helpers_) return false;
  helped_ = helpers_->any();
  return helped_;
}

void PairWork::end(bool unfinished) {
  if (unfinished) return;
  std::erase_if(announced_, [&](const PairTask& task) { return open_.erase(task.digest) == 0; });
  if (!announced_.empty()) helpers_->withdraw(announced_);
}

const std::string& PairWork::digest(SessionId id, const CloudSource& clouds) {
  std::string& known = (*digests_)[id];
  if (known.empty()) known = search_.digest(id, clouds);
  return known;
}

std::optional<PairTask> PairWork::task_of(const OrderedPair& pair, const CloudSource& clouds) {
  if (!sessions_.contains(pair.a) || !sessions_.contains(pair.b)) return std::nullopt;
  const Session &a = sessions_.at(pair.a), &b = sessions_.at(pair.b);
  // How a session looks like itself depends also on which clouds can be requested.
  if (pair.a == pair.b && std::any_of(a.keyframes.begin(), a.keyframes.end(), [&](const Keyframe& k) {
        return clouds.state({pair.a, k.sequence}) == CloudState::obtainable;
      }))
    return std::nullopt;
  return PairTask{pair.a,
                  pair.b,
                  a.keyframes.size(),
                  b.keyframes.size(),
                  a.complete,
                  b.complete,
                  digest(pair.a, clouds) + digest(pair.b, clouds)};
}

void PairWork::announce(const std::vector<OrderedPair>& pairs, const std::vector<OrderedPair>& later,
                        const CloudSource& clouds) {
  std::vector<PairTask> tasks;
  std::set<std::string> seen;
  const auto add = [&](const OrderedPair& pair) {
    auto task = task_of(pair, clouds);
    if (!task || ahead_.contains(task->digest) || !seen.insert(task->digest).second) return;
    open_.insert(task->digest);
    tasks.push_back(std::move(*task));
  };
  std::for_each(pairs.begin(), pairs.end(), add);
  announced_ = tasks;
  std::for_each(later.begin(), later.end(), add);
  if (!tasks.empty()) helpers_->announce(tasks);
}

std::optional<PairFindings> PairWork::kept(const std::string& digest) {
  const auto found = ahead_.find(digest);
  if (found == ahead_.end()) return std::nullopt;
  PairFindings out = std::move(found->second);
  ahead_.erase(found);
  std::erase(order_ahead_, digest);
  return out;
}

std::optional<PairFindings> PairWork::findings(const OrderedPair& pair, CloudSource& clouds) {
  if (!digests_ || (open_.empty() && ahead_.empty())) return std::nullopt;
  const auto task = task_of(pair, clouds);
  if (!task) return std::nullopt;
  if (auto known = kept(task->digest)) return known;
  if (open_.erase(task->digest) == 0) return std::nullopt;
  PairHelpers::Answer answer = helpers_->ask(*task);
  bool busy = false;
  while (answer.turn == PairHelpers::Turn::others && search_one_ahead(clouds)) {
    busy = true;
    answer = helpers_->ask(*task);
  }
  if (answer.turn == PairHelpers::Turn::others) answer = helpers_->wait(*task);
  if (busy) clouds.working_on(pair.a, pair.b);
  if (answer.turn != PairHelpers::Turn::done) return std::nullopt;
  auto found = decode_findings(answer.result);
  return found ? std::optional(std::move(*found)) : std::nullopt;
}

/// Returns false if there is nothing on which nobody works.
bool PairWork::search_one_ahead(CloudSource& clouds) {
  const auto next = helpers_->claim();
  if (!next) return false;
  const auto now = task_of({next->a, next->b}, clouds);
  open_.erase(next->digest);
  if (!now || now->digest != next->digest) return true;  // a session has changed since it was announced
  clouds.working_on(next->a, next->b);
  ahead_.emplace(next->digest, search_.find(next->a, next->b, clouds));
  order_ahead_.push_back(next->digest);
  if (order_ahead_.size() <= most_kept) return true;
  ahead_.erase(order_ahead_.front());
  order_ahead_.pop_front();
  return true;
}

}  // namespace headframe
