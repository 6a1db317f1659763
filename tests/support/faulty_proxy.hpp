#pragma once
// A bad link in this process, for machines where no namespaces may be made.

#include <cstdint>
#include <memory>

namespace headframe::test {

struct LinkFaults {
  std::uint32_t seed = 1;
  int cuts = 10;                   // connections that are closed in the middle, first
  int stalls = 1;                  // then connections that fall silent and stay open
  std::size_t most_bytes = 60000;  // of both directions together, until it happens
  double bytes_per_s = 0;          // in each direction; 0: as fast as they come
};

/// Forwards connections to 127.0.0.1:port in pieces of 1 to 1500 bytes, and breaks them at seeded places; when all
/// faults are spent it forwards for good. Runs a thread of its own.
class FaultyProxy {
 public:
  FaultyProxy(std::uint16_t port, const LinkFaults& faults);
  ~FaultyProxy();

  std::uint16_t port() const;  // where it listens
  int faults() const;          // that have happened
  int connections() const;     // that were taken
  void stall(int connection);  // 0: the first; it falls silent now and stays open
  std::uint64_t bytes_to_server() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace headframe::test
