#pragma once
// One connection with the client: what the station says, and every rule of the protocol that holds for what the client
// says, whatever the scenario is.

#include <algorithm>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include "tests/conformance/judge.hpp"
#include "tests/conformance/peer.hpp"

namespace headframe::conformance {

/// What the station remembers between connections, as its database would.
struct Station {
  std::uint64_t last_keyframe = 0;                // that ever came
  std::set<std::uint64_t> refused, acknowledged;  // clouds
};

/// Not thread safe.
class Conversation {
 public:
  Conversation(Peer& peer, Judge& judge, Findings& findings, Station& station, Clock::duration patience)
      : peer_(peer), judge_(judge), findings_(findings), station_(station), patience_(patience) {}

  /// The handshake and the hello. False: the connection is of no use.
  bool greet();

  void welcome(std::uint64_t durable, const std::vector<std::uint64_t>& clouds = {}, bool in_pieces = false);
  void acknowledge(std::uint64_t keyframe);
  void acknowledge_cloud(std::uint64_t sequence);
  void refuse_cloud(std::uint64_t sequence);
  void request(const std::vector<std::uint64_t>& sequences);
  /// Until it is called with an empty text nothing may come but control messages, from the answer to a ping on.
  void hold(const std::string& why);
  void pace(std::uint64_t bytes_per_s);
  void tell_transforms(const std::string& robot, const std::string& session);
  void say(const v1::ServerMessage& message) { (void)peer_.send(message); }
  void error(v1::ErrorKind kind, bool permanent);

  /// Reads until it holds. False: the client sent no keyframe and no chunk for too long or went away first, which is
  /// reported under `kind` unless that is empty.
  bool until(const std::function<bool()>& holds, const std::string& kind, const std::string& awaited);
  /// Reads whatever comes before the answer to a ping: all that was said before is dealt with then.
  bool settle();
  /// Reads for so long, or until the client has closed.
  void listen(Clock::duration most);

  std::uint64_t last() const { return last_; }  // keyframe on this connection
  std::uint64_t backlog() const { return backlog_; }
  bool has_cloud(std::uint64_t sequence) const { return answered_.contains(sequence); }  // or that it will not come
  bool whole(std::uint64_t sequence) const {
    return std::find(unacknowledged_.begin(), unacknowledged_.end(), sequence) != unacknowledged_.end();
  }
  bool begun(std::uint64_t sequence) const { return open_.contains(sequence) || has_cloud(sequence); }
  bool said_goodbye() const { return goodbye_; }
  bool closed() const { return closed_; }
  const std::string& session() const { return session_; }
  const std::vector<std::uint64_t>& unacknowledged_clouds() const { return unacknowledged_; }

 private:
  bool step(Clock::time_point until);
  void observe(const v1::RobotMessage& message);
  void on_keyframe(const v1::Keyframe& keyframe);
  void on_chunk(const v1::CloudChunk& chunk);
  void on_whole(std::uint64_t sequence, const std::string& encoded);
  void on_unavailable(const v1::SubmapUnavailable& message);
  void on_goodbye(const v1::Goodbye& goodbye);
  void answered(std::uint64_t sequence);
  void pong(const v1::Ping& ping);

  struct Open {
    std::uint32_t total = 0;
    std::string bytes;
  };
  Peer& peer_;
  Judge& judge_;
  Findings& findings_;
  Station& station_;
  const Clock::duration patience_;
  std::string session_;
  bool welcomed_ = false, held_ = false, goodbye_ = false, closed_ = false;
  std::uint64_t durable_ = 0, last_ = 0, backlog_ = 0, nonce_ = 1000;
  std::uint64_t progress_ = 0;  // keyframes and chunks that came
  std::set<std::uint64_t> pongs_;
  std::map<std::uint64_t, Open> open_;   // clouds that come in chunks
  std::deque<std::uint64_t> requested_;  // and not answered yet, in order
  std::set<std::uint64_t> asked_;        // ever, here
  std::set<std::uint64_t> answered_, skipped_;
  std::vector<std::uint64_t> unacknowledged_;
};

}  // namespace headframe::conformance
