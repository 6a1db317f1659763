#include "server/security/attempt_limiter.hpp"

#include <algorithm>

namespace headframe {
namespace {

std::string key_of(const boost::asio::ip::address& from) {
  if (from.is_v4()) return from.to_string();
  const auto v6 = from.to_v6();
  if (v6.is_v4_mapped()) return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, v6).to_string();
  const auto bytes = v6.to_bytes();
  return {reinterpret_cast<const char*>(bytes.data()), 8};
}

}  // namespace

void AttemptLimiter::forgive(Entry& entry, Time now) const {
  const double passed_s = std::chrono::duration<double>(now - entry.seen).count();
  if (passed_s <= 0) return;  // another thread read the clock later
  entry.failures = std::max(0.0, entry.failures - passed_s * limits_.forgiven_per_s);
  entry.seen = now;
}

bool AttemptLimiter::allowed(const boost::asio::ip::address& from, Time now) {
  const std::lock_guard lock(mutex_);
  const auto found = index_.find(key_of(from));
  if (found == index_.end()) return true;
  forgive(*found->second, now);
  return found->second->failures <= limits_.failures - 1;
}

void AttemptLimiter::failed(const boost::asio::ip::address& from, Time now) {
  const std::string key = key_of(from);
  const std::lock_guard lock(mutex_);
  if (const auto found = index_.find(key); found != index_.end()) {
    entries_.splice(entries_.begin(), entries_, found->second);
    forgive(entries_.front(), now);
  } else {
    if (entries_.size() >= limits_.addresses) {
      index_.erase(entries_.back().key);
      entries_.pop_back();
    }
    entries_.push_front({key, 0, now});
    index_[key] = entries_.begin();
  }
  entries_.front().failures = std::min(entries_.front().failures + 1, limits_.failures);
}

std::size_t AttemptLimiter::remembered() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

}  // namespace headframe
