#pragma once
// The robot's side of protocol v1 for one connection, without sockets, threads or a clock of its own: bytes and times
// in, events and frames out.

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

/// Where the protocol takes what it sends. The spool, or a table in tests.
class UplinkSource {
 public:
  virtual ~UplinkSource() = default;
  virtual std::uint64_t last_sequence() const = 0;
  virtual Result<Keyframe> keyframe(std::uint64_t sequence) const = 0;
  virtual bool holds_cloud(std::uint64_t sequence) const = 0;
  virtual std::uint64_t next_held_cloud(std::uint64_t from) const = 0;  // 0: none at or after `from`
  virtual Result<std::string> cloud(std::uint64_t sequence) const = 0;
  /// Updates of poses of keyframes: the newest, how many keyframes there were when one was made, and what some say
  /// together, by rising sequence.
  virtual std::uint64_t last_pose_update() const { return 0; }
  virtual std::uint64_t keyframes_at_update(std::uint64_t /*number*/) const { return 0; }
  virtual Result<std::vector<KeyframePose>> poses(std::uint64_t /*first*/, std::uint64_t /*last*/) const {
    return std::vector<KeyframePose>();
  }
  /// Where the robot is and how it is, as far as is known; none: nothing is to be said of it.
  virtual std::optional<LiveState> live() const { return std::nullopt; }
};

// Events.
struct Welcomed {
  std::uint64_t spares = 0;                 // how many connections may stand beside this one
  std::vector<std::string> capabilities{};  // of the server; empty: it is older than those
};
struct KeyframesDurable {
  std::uint64_t up_to = 0;
};
struct PosesDurable {
  std::uint64_t up_to_update = 0;
};
struct CloudsDurable {  // both inclusive; a peer's numbers: clamp before walking from one to the other
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
  std::string hold;        // not empty: why the server takes nothing for now
  std::string cut = {};    // not empty: why the session's last keyframes are left out of merging
};
/// Of what others know around the robot; for the SurroundingsBook.
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
  std::size_t keyframes_in_flight = 64;  // sent and not acknowledged
  std::size_t clouds_in_flight = 16;
  double welcome_s = 10;     // a server that does not welcome within this is given up
  double ping_s = 10;        // silence after which the server is asked
  double silence_s = 75;     // silence after which it is given up: longer than a link may be dark
  double doubt_s = 5;        // an answer that takes this long puts the link in doubt; asked for after half of it
  double spare_ping_s = 45;  // silence after which the server is asked on a spare
};

/// What a peer wrote, for people: cut, and without control characters.
std::string printable_text(const std::string& peer_text);

/// Not thread safe. Frames come by priority: control, how the robot is (each second at most), keyframes and updates of
/// poses as they were made, chunks of requested clouds, chunks of background clouds. An update goes after the keyframes
/// that there were when it was made and before those that came later. A requested cloud overtakes one that is on its
/// way in the background between two chunks; never are more than two clouds open.
class UplinkProtocol {
 public:
  using Time = std::chrono::steady_clock::time_point;

  UplinkProtocol(const UplinkLimits& limits, const Hello& hello, const UplinkSource& source, Time now);

  std::vector<UplinkEvent> receive(std::string_view bytes, Time now);
  std::vector<UplinkEvent> tick(Time now);

  /// The next frame to write; nullopt: nothing may be sent now. Ask again after an event or when the source grew. A
  /// chunk takes at most chunk_bytes of its cloud; 0: no chunk now. `events` gets what went wrong with the source.
  std::optional<std::string> next_frame(Time now, std::size_t chunk_bytes, std::vector<UplinkEvent>& events);

  /// Something was sent that the server answers at once, and for doubt_s nothing has come: try another connection.
  bool doubtful(Time now) const;

  void trigger(const std::string& reason);

  /// After the welcome: asks where the robot is, or no more. False: the server does not know the question.
  bool localize(bool asks);

  /// After the welcome: asks what others know. False: the server does not know such questions.
  bool ask_around(const v1::RobotMessage& question);

  /// Nothing follows this; the caller closes once it is written.
  void goodbye(bool complete);

  /// A spare from now on: a connection beside the one that carries the session. Nothing but pings, pongs and probes go.
  void stand_by();

  /// Asks on a spare that was welcomed whether its way is open, with the first keyframe behind `durable` if there is
  /// one.
  void probe(std::uint64_t durable);
  /// The probe was answered: the way is open.
  bool answered() const { return probed_ == Probed::answered; }

  /// The spare carries the session from now on; says what it was told before.
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
  bool asked_ = false;                // a ping since anything was heard
  std::optional<Time> answer_since_;  // an answer has been due since then, and nothing was heard
  std::uint64_t pings_ = 0;
  FrameReader frames_;
  std::deque<std::string> control_;  // bounded: see queue()
  PolicyTold policy_;                // as told last
  bool carries_ = true;              // the session; false: a spare
  bool carried_alone_ = true;        // never a spare: what is acknowledged was sent here
  Probed probed_ = Probed::no;
  bool localizes_ = false;        // the server knows the question
  bool knows_around_ = false;     // and those about others
  bool takes_live_ = false;       // and how the robot is
  bool takes_poses_ = false;      // and updates of poses
  bool takes_intensity_ = false;  // and clouds that hold intensities
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
  std::set<std::uint64_t> clouds_in_flight_;  // wholly sent, not acknowledged
  std::uint64_t background_from_ = 1;         // clouds before it were sent or are gone
  std::optional<Time> live_said_at_;
  LiveState live_said_;
  std::optional<Transfer> requested_transfer_, background_transfer_;
  std::optional<Transforms> pages_;  // of an update whose other pages are still to come, from next_page_ on
  std::uint32_t next_page_ = 0;
};

}  // namespace headframe
