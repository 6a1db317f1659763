#pragma once
// Two network namespaces and a bad radio between them: what netem does, in user space, so that no kernel module is
// needed. IP packets go from one TUN device to the other, lost, delayed and held back on the way.

#include <functional>
#include <memory>
#include <string>

#include "common/result.hpp"

namespace headframe::bench {

struct RadioConditions {
  std::string name;
  double loss = 0;         // of packets, each direction
  double delay_s = 0;      // robot to server; the way back is not delayed: netem on the robot's interface
  double jitter_s = 0;     // uniform, +-; packets overtake each other
  double bytes_per_s = 0;  // each direction; 0: no limit
  double queue_s = 1;      // a packet that would wait longer for its turn is dropped
  double blackout_s = 0;   // at the end of every period; nothing passes
  double period_s = 60;
};

/// Needs root (CAP_NET_ADMIN) and /dev/net/tun. Thread safe.
class BadLink {
 public:
  static Result<std::unique_ptr<BadLink>> make(std::uint32_t seed);
  ~BadLink();

  static constexpr const char* server_address = "10.77.0.1";

  /// From now on; periods begin now.
  void set(const RadioConditions& conditions);

  /// Run `work` on a thread in the robots' or the server's namespace and wait for it. Threads and processes that it
  /// starts stay there.
  void as_robot(const std::function<void()>& work);
  void as_server(const std::function<void()>& work);

  /// Bytes of IP packets that reached the server's side.
  std::uint64_t bytes_to_server() const;

 private:
  struct Radio;
  explicit BadLink(std::unique_ptr<Radio> radio);
  std::unique_ptr<Radio> radio_;
};

}  // namespace headframe::bench
