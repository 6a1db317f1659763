#pragma once
// The protocol over a connection, TLS or plain TCP, that comes back by itself.

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
  std::vector<Endpoint> more_servers;  // of the same base station: tried in turn when one can not be reached
  std::string fingerprint;  // of the server's certificate, 32 bytes: TLS 1.3 with it alone; empty: in the clear
  double bytes_per_s = 0;   // budget of what is sent; 0: no limit
  double retry_first_s = 0.5;
  double retry_most_s = 1.5;       // a base station that is back is found within this
  double connect_s = 5;            // a connection that is not up within this is given up
  double connect_again_s = 1;      // while one is not up, another is tried beside it: at most four; the first up stays
  double close_s = 5;              // for the goodbye
  double spare_connect_s = 10;     // the same of a spare, which is in no hurry
  std::size_t spares = 7;          // kept beside the first over a link that loses packets; the server may allow less
  double spares_from_loss = 0.02;  // of the packets, lost; 0: spares are always kept
  UplinkLimits limits;
};

/// A link that falls silent though an answer is due is doubted: others are tried beside it, and the first that speaks
/// stays. Over a link that loses packets spares stand ready for that: TCP sends again once a second at most, eight
/// connections one after the other eight times. Where there are more servers, a lost link, or an attempt that failed,
/// is followed at once by one to the next of them, and a pause comes when all have failed. Runs a thread of its own
/// between construction and close(). All calls are thread safe.
class Uplink {
 public:
  /// on_event is called on the uplink's thread and must not throw; LinkEnded comes once for every connection or attempt
  /// that ends; after a permanent one no other follows. `source` must be thread safe and outlive this.
  Uplink(const UplinkConfig& config, const Hello& hello, const UplinkSource& source,
         std::function<void(const UplinkEvent&)> on_event);

  /// The source has grown.
  void wake();

  /// Asks the server to merge now; kept until a connection is there (the last one only).
  void trigger(const std::string& reason);

  /// Asks where the robot is, over this and every later connection, until it is called with false. Answers come as
  /// Localization, also that a server does not know the question.
  void localize(bool asks);

  // Asks what others know, over this and every later connection, until it is called with false. Answers come as
  // Trajectories, Coverage and MapAround, also that a server does not know the question. One map at a time is asked
  // for.
  void trajectories(bool asks);
  void coverage(bool asks);
  void map_around(const MapQuestion& question);

  /// Says goodbye if connected, waits for the server to hang up (at most config.close_s) and ends the thread. Not to be
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
