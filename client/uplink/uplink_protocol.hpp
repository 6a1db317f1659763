#pragma once
// The robot's side of protocol v1 for one connection, without sockets, threads or a clock: takes bytes and times,
// returns events and frames.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "client/localization.hpp"
#include "client/surroundings.hpp"
#include "client/transforms.hpp"
#include "common/result.hpp"
#include "common/session/keyframe_pose.hpp"
#include "common/wire/convert.hpp"
#include "common/wire/frame_codec.hpp"

namespace headframe {

/// The source of what the protocol sends: the spool, or a table in tests.
class UplinkSource {
 public:
  virtual ~UplinkSource() = default;
  virtual std::uint64_t last_sequence() const = 0;
  virtual Result<Keyframe> keyframe(std::uint64_t sequence) const = 0;
  virtual bool holds_cloud(std::uint64_t sequence) const = 0;
  virtual std::uint64_t next_held_cloud(std::uint64_t from) const = 0;  // 0: none at or after `from`
  virtual Result<std::string> cloud(std::uint64_t sequence) const = 0;
  /// Updates of keyframe poses: the number of the newest, how many keyframes there were when one was made, and the
  /// combined poses of several, by rising sequence.
  virtual std::uint64_t last_pose_update() const { return 0; }
  virtual std::uint64_t keyframes_at_update(std::uint64_t /*number*/) const { return 0; }
  virtual Result<std::vector<KeyframePose>> poses(std::uint64_t /*first*/, std::uint64_t /*last*/) const {
    return std::vector<KeyframePose>();
  }
  /// The robot's position and condition, as far as known; nullopt: nothing is to be reported.
  virtual std::optional<LiveState> live() const { return std::nullopt; }
};

// Events.
struct Welcomed {
  std::uint64_t spares = 0;                 // how many further connections the server allows beside this one
  std::vector<std::string> capabilities{};  // of the server; empty: its version predates the list
};
struct KeyframesDurable {
  std::uint64_t up_to = 0;
};
struct PosesDurable {
  std::uint64_t up_to_update = 0;
};
struct CloudsDurable {  // both inclusive; untrusted numbers: clamp before iterating over them
  std::uint64_t first = 0, last = 0;
};
struct CloudUnreadable {
  std::uint64_t sequence = 0;
  Error error;
};
struct CloudRefused {  // by the server, for good
  std::uint64_t sequence = 0;
  std::string reason;
};
struct PolicyTold {
  double bytes_per_s = 0;  // 0: no limit
  std::string hold;        // if not empty: why the server accepts nothing for now
  std::string cut = {};    // if not empty: why the session's last keyframes are left out of merging
};
/// What others know around the robot; for the SurroundingsBook.
struct SurroundingsMessage {
  std::shared_ptr<const v1::ServerMessage> message;
};
struct LinkEnded {
  Error error;
  bool permanent = false;  // connecting again will not help
};
using UplinkEvent =
    std::variant<Welcomed, KeyframesDurable, PosesDurable, CloudsDurable, CloudUnreadable, CloudRefused, Transforms,
                 Localization, Trajectories, Coverage, MapAround, SurroundingsMessage, PolicyTold, LinkEnded>;

struct UplinkLimits {
  std::size_t keyframes_in_flight = 64;  // sent but not acknowledged
  std::size_t clouds_in_flight = 16;
  double welcome_s = 10;  // a server that does not welcome the robot within this is given up
  double ping_s = 10;     // silence after which the server is pinged
  double silence_s = 75;  // silence after which it is given up: longer than usual gaps in radio coverage
  double doubt_s = 5;  // a due answer that takes this long puts the link in doubt; it is asked for after half of this
  double spare_ping_s = 45;  // silence after which the server is pinged on a spare connection
};

/// A peer's text made safe to show: cut to length and without control characters.
std::string printable_text(const std::string& peer_text);

/// Not thread safe. Frames are sent by priority: control; the robot's condition (at most once a second); keyframes and
/// pose updates in the order they were made; chunks of requested clouds; chunks of background clouds. An update goes
/// after the keyframes that existed when it was made and before later ones. A requested cloud overtakes, between two
/// chunks, one that is being sent in the background; at most two clouds are open at a time.
class UplinkProtocol {
 public:
  using Time = std::chrono::steady_clock::time_point;

  UplinkProtocol(const UplinkLimits& limits, const Hello& hello, const UplinkSource& source, Time now);

  std::vector<UplinkEvent> receive(std::string_view bytes, Time now);
  std::vector<UplinkEvent> tick(Time now);

  /// The next frame to write; nullopt: nothing may be sent now. Ask again after an event or when the source has new
  /// data. A chunk takes at most chunk_bytes of its cloud; 0: no chunk now. `events` gets faults of the source.
  std::optional<std::string> next_frame(Time now, std::size_t chunk_bytes, std::vector<UplinkEvent>& events);

  /// Whether something was sent that the server answers at once, and nothing was received for doubt_s: then another
  /// connection should be tried.
  bool doubtful(Time now) const;

  void trigger(const std::string& reason);

  /// After the welcome: starts or stops asking where the robot is. False: the server does not know the question.
  bool localize(bool asks);

  /// After the welcome: asks what others know. False: the server does not know such questions.
  bool ask_around(const v1::RobotMessage& question);

  /// Ends the conversation; the caller closes the connection once this is written.
  void goodbye(bool complete);

  /// Makes this a spare connection beside the one that carries the session. Sends only pings, pongs and probes.
  void stand_by();

  /// On a welcomed spare: tests whether it gets through, sending along the first keyframe after `durable` if there is
  /// one.
  void probe(std::uint64_t durable);
  /// Whether the probe was answered, so that the spare gets through.
  bool answered() const { return probed_ == Probed::answered; }

  /// The spare carries the session from now on. Returns events with what the server told it before.
  std::vector<UplinkEvent> take_over();

  bool welcomed() const { return state_ == State::welcomed; }
  bool ended() const { return state_ == State::ended; }

 private:
  enum class State { welcome_awaited, welcomed, ended };
  enum class Probed { no, asked, answered };
  using Events = std::vector<UplinkEvent>;
  struct Transfer {
    std::uint64_t sequence = 0;
    std::string bytes;
    std::size_t offset = 0;
  };

  void handle(const v1::ServerMessage& message, Events& events);
  void on_welcome(const v1::Welcome& message, Events& events);
  void on_keyframe_ack(std::uint64_t up_to, Events& events);
  void on_poses_ack(std::uint64_t up_to, Events& events);
  void on_cloud_ack(std::uint64_t sequence, Events& events);
  void on_cloud_refusal(const v1::CloudRefusal& message, Events& events);
  void on_submap_request(const v1::SubmapRequest& message);
  void on_transforms(const v1::TransformUpdate& message, Events& events);
  bool joins_pages(const v1::TransformUpdate& message, Transforms& transforms);
  void on_localization(const v1::Localization& message, Events& events);
  void on_error(const v1::ErrorReport& message, Events& events);
  void end(Events& events, ErrorCode code, const std::string& message, bool permanent);
  void queue(const v1::RobotMessage& message);
  bool queue_frames(std::string frames);
  std::string hello_frame() const;
  Result<v1::RobotMessage> next_keyframe() const;
  bool queue_next_keyframe(Events& events);
  bool queue_poses(std::size_t chunk_bytes, Events& events);
  bool begin_poses(Events& events);
  void queue_live(Time now);
  void queue_next_chunk(std::size_t chunk_bytes, Events& events);
  void expect_answer(Time now);
  std::uint64_t next_background();
  bool wanted(std::uint64_t sequence) const;
  void begin(std::optional<Transfer>& transfer, std::uint64_t sequence, Events& events);
  void queue_chunk(std::optional<Transfer>& transfer, std::size_t chunk_bytes);
  void ping();

  const UplinkLimits limits_;
  const Hello hello_;
  const UplinkSource& source_;
  State state_ = State::welcome_awaited;
  Time born_, heard_;
  bool asked_ = false;                // pinged since anything was received
  std::optional<Time> answer_since_;  // an answer has been due since then, and nothing was received
  std::uint64_t pings_ = 0;
  FrameReader frames_;
  std::deque<std::string> control_;  // bounded: see queue()
  PolicyTold policy_;                // as last received
  bool carries_ = true;              // carries the session; false: it is a spare
  bool carried_alone_ = true;        // it was never a spare: all acknowledged data was sent on it
  Probed probed_ = Probed::no;
  bool localizes_ = false;        // the server knows the question where the robot is
  bool knows_around_ = false;     // ... and those about others
  bool takes_live_ = false;       // ... and the robot's condition
  bool takes_poses_ = false;      // ... and updates of poses
  bool takes_intensity_ = false;  // ... and clouds with intensities
  bool said_hello_ = false, said_goodbye_ = false;
  std::uint64_t sent_keyframes_ = 0, durable_keyframes_ = 0;
  struct PoseTransfer {
    std::uint64_t number = 0;  // of the last update in it
    std::vector<KeyframePose> poses;
    std::size_t offset = 0;
  };
  std::optional<PoseTransfer> pose_transfer_;
  std::uint64_t sent_update_ = 0, durable_update_ = 0;
  std::deque<std::uint64_t> requested_;       // clouds the server wants, in its order; each at most once
  std::set<std::uint64_t> clouds_in_flight_;  // sent completely, not acknowledged
  std::uint64_t background_from_ = 1;         // clouds before it were sent or dropped
  std::optional<Time> live_said_at_;
  LiveState live_said_;
  std::optional<Transfer> requested_transfer_, background_transfer_;
  std::optional<Transforms> pages_;  // of an update whose other pages are still to come, from next_page_ on
  std::uint32_t next_page_ = 0;
};

}  // namespace headframe
