#pragma once
// Robots that ask what others know around them: which questions stand, and who is answered when.

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "headframe/v1/robot.pb.h"
#include "server/net/fair_pool.hpp"
#include "server/net/robot_events.hpp"
#include "server/surroundings/component_maps.hpp"

namespace headframe {

/// One answer at a time is on its way to a robot: until it has asked for the next there is none, so that no more than
/// one page stands before an acknowledgement. A page grows and shrinks with the time that the last ones took to be
/// asked on from: about a tenth of a second, however thin the link. All work is done on one thread of its own, in turns
/// of one piece for each robot. Thread safe; nothing here blocks.
class SurroundingsDesk {
 public:
  using Clock = std::chrono::steady_clock;
  using Payload = std::shared_ptr<const std::string>;  // a serialised ServerMessage
  /// The component that the session is part of now; asked on the thread of this.
  using Around = std::function<SessionSurroundings(SessionId)>;
  using Tell = std::function<void(SessionId, SurroundingsKind, Payload)>;

  using Now = std::function<Clock::time_point()>;

  SurroundingsDesk(Store& store, std::uint64_t first_epoch, Around around, Tell tell, Now now = Clock::now)
      : maps_(store, first_epoch), around_(std::move(around)), tell_(std::move(tell)), now_(std::move(now)) {}
  ~SurroundingsDesk() { stop(); }
  /// What runs ends, and nobody is answered any more. To be called while the store is there.
  void stop();
  SurroundingsDesk(const SurroundingsDesk&) = delete;
  SurroundingsDesk& operator=(const SurroundingsDesk&) = delete;

  // Of each kind one question of a session stands; a newer one takes its place.
  void ask(SessionId session, const SurroundingsAsked& question);
  void ask(SessionId session, const MapAsked& question);
  void ask(SessionId session, const MapNextAsked& question);
  /// Its connection has ended: nothing stands any more.
  void left(SessionId session);

  /// Of any session something has come, or the atlas has changed.
  void changed() { ++changes_; }
  /// To be called often while the session is connected: answers what can be answered by now. bytes_per_s: what it may
  /// be sent; 0: no limit.
  void look(SessionId session, std::uint64_t bytes_per_s);

  static constexpr std::size_t least_page_bytes = 1024, most_page_bytes = 16384;  // about; the first is the least
  static constexpr auto quick = std::chrono::milliseconds(50), slow = std::chrono::milliseconds(200);  // to be asked on
  static constexpr auto look_every = std::chrono::seconds(1);  // for what is new
  static constexpr auto unasked = std::chrono::seconds(5);     // who has not asked on by then is sent other answers

 private:
  struct Question {
    HeldVersion held;
    bool looked = false;            // there was nothing newer ...
    std::uint64_t changes = 0;      // ... when so much had changed
    Clock::time_point looked_at{};  // and then
  };
  struct Map {
    MapAsked question;
    std::optional<std::uint32_t> wanted;  // from here on; none: nothing now
    v1::MapPart head;                     // the first part, without its data
    std::string encoded;
    bool made = false;
  };
  struct Asking {
    std::map<SurroundingsKind, Question> questions;  // trajectories, coverage
    std::optional<Map> map;
    bool working = false;
    SurroundingsKind last = SurroundingsKind::map;   // what was answered last: another comes first
    Clock::time_point waits_until{}, paced_until{};  // waits_until: set while an answer is on its way
    Clock::time_point answered{};
    std::size_t page_bytes = least_page_bytes;
    std::uint64_t bytes_per_s = 0;
  };

  /// Asks on or anew, under the lock.
  Asking& asks(SessionId session);
  void go_on(SessionId session);
  static bool due(const Question& question, std::uint64_t changes, Clock::time_point now);
  std::optional<SurroundingsKind> next(const Asking& asking, Clock::time_point now) const;
  void work(SessionId session, SurroundingsKind kind);
  void answer(SessionId session, SurroundingsKind kind, const HeldVersion& held, std::size_t page_bytes);
  Payload page(SessionId session, SurroundingsKind kind, const HeldVersion& held, std::size_t page_bytes);
  void make_map(SessionId session, const MapAsked& question);
  static Payload part(Map& map, std::size_t page_bytes);
  void note_sent(Asking& asking, SurroundingsKind kind, std::size_t bytes) const;

  std::mutex mutex_;
  std::map<SessionId, Asking> asking_;
  bool stopped_ = false;
  std::atomic<std::uint64_t> changes_ = 1;
  ComponentMaps maps_;  // of the pool's thread
  const Around around_;
  const Tell tell_;
  const Now now_;
  std::optional<FairPool> pool_{1};  // none: stopped. Last: its work is done before what it uses goes
};

}  // namespace headframe
