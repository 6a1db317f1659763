#pragma once
// The protocol over a connection (TLS or plain TCP) that is re-established automatically.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/uplink/uplink_protocol.hpp"
#include "common/endpoint.hpp"

namespace headframe {

struct UplinkConfig {
  std::string host;
  std::uint16_t port = 0;
  std::vector<Endpoint> more_servers;  // of the same base station: tried in turn if one cannot be reached
  std::string fingerprint;  // of the server's certificate, 32 bytes: TLS 1.3, this one only; empty: unencrypted
  double bytes_per_s = 0;   // limit of what is sent; 0: none
  double retry_first_s = 0.5;
  double retry_most_s = 1.5;       // a base station that returns is found within this
  double connect_s = 5;            // an attempt that does not connect within this is given up
  double connect_again_s = 1;      // until one is up, another attempt starts after each of these; at most four
  double close_s = 5;              // limit for the goodbye
  double spare_connect_s = 10;     // like connect_s, for a spare connection, which is less urgent
  std::size_t spares = 7;          // spare connections on a link that loses packets; the server may allow fewer
  double spares_from_loss = 0.02;  // share of lost packets from which on spares are kept; 0: always
  UplinkLimits limits;
};

/// If a connection goes silent although an answer is due, it is in doubt: others are tried beside it, and the first
/// that answers is used. On a link that loses packets, spare connections are kept for this: TCP retransmits at most
/// once a second, but eight connections do so eight times. With several servers, a lost connection or a failed attempt
/// is followed at once by an attempt at the next server, with a pause after all have failed. Runs its own thread from
/// construction to close(). All calls are thread safe.
class Uplink {
 public:
  /// on_event is called on the uplink's thread and must not throw. LinkEnded comes once for every connection or attempt
  /// that ends; after a permanent one nothing follows. `source` must be thread safe and outlive this object.
  Uplink(const UplinkConfig& config, const Hello& hello, const UplinkSource& source,
         std::function<void(const UplinkEvent&)> on_event);

  /// Call when the source has new data.
  void wake();

  /// Asks the server to merge now. Without a connection the last request is kept until there is one.
  void trigger(const std::string& reason);

  /// Asks where the robot is, on this and every later connection, until called with false. Answers arrive as
  /// Localization, also if the server does not know the question.
  void localize(bool asks);

  // Asks what others know, on this and every later connection, until called with false. Answers arrive as Trajectories,
  // Coverage and MapAround, also if the server does not know the question. Only one map is requested at a time.
  void trajectories(bool asks);
  void coverage(bool asks);
  void map_around(const MapQuestion& question);

  /// Says goodbye if connected, waits for the server to close (at most config.close_s) and ends the thread. Not to be
  /// called from on_event.
  void close(bool complete);

  bool connected() const;
  std::uint64_t bytes_sent() const;

  ~Uplink();

 private:
  struct Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace headframe
