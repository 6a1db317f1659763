#pragma once

#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstdint>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace headframe {

/// How often an address may fail (or send requests, if each one counts); defaults live only here.
struct AttemptLimits {
  double failures = 10;             // in a row; then the address has to wait
  double forgiven_per_s = 1.0 / 6;  // one failure is forgotten every 6 s
  std::size_t addresses = 4096;     // remembered; beyond, the one whose last failure is oldest is forgotten
};

/// Counts failed attempts by address (for IPv6 by /64, as whoever has one address of it has all). Thread safe.
class AttemptLimiter {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit AttemptLimiter(const AttemptLimits& limits = {}) : limits_(limits) {}

  /// Whether this address may try now.
  bool allowed(const boost::asio::ip::address& from, Time now);
  void failed(const boost::asio::ip::address& from, Time now);

  std::size_t remembered() const;

 private:
  struct Entry {
    std::string key;
    double failures = 0;
    Time seen;
  };
  using Entries = std::list<Entry>;  // the one with the latest failure first

  void forgive(Entry& entry, Time now) const;

  const AttemptLimits limits_;
  mutable std::mutex mutex_;
  Entries entries_;
  std::unordered_map<std::string, Entries::iterator> index_;
};

}  // namespace headframe
