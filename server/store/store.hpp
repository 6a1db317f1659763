#pragma once
// The data of the base station: sessions, keyframes, clouds, alignments, revisions; in SQLite or PostgreSQL.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe.hpp"
#include "common/session/keyframe_pose.hpp"
#include "server/atlas/atlas.hpp"
#include "server/atlas/decisions.hpp"
#include "server/atlas/frozen.hpp"
#include "server/atlas/pose_constraint.hpp"
#include "server/atlas/survey.hpp"
#include "server/session/ids.hpp"
#include "server/session/self_likeness.hpp"

namespace headframe {

struct SessionRecord {
  SessionId id = 0;
  SessionKey key;
  Sensor sensor;
  FamilyId family;
  std::uint32_t q_size = 0;
  std::uint32_t w_size = 0;
  std::uint64_t spool_id = 0;
  std::uint64_t spool_run = 0;            // the last admitted run of the spool; 0: not stated
  bool complete = false;                  // the robot said that no further keyframe follows
  std::uint64_t attempted_keyframes = 0;  // number of keyframes that the last finished merge attempt used
  bool attempted_whole = false;           // ... and the session had then ended or paused
  bool archived = false;                  // kept, but left out of everything until it is restored
  std::string site = {};                  // the operator's name for the mine it was driven in; empty: there is only one
  std::uint64_t pose_update = 0;          // the newest stored update of poses; for a session with parts, of all parts
};

/// A robot that is or may be enrolled. Only digests are stored: SHA-256 of long random secrets.
struct RobotRecord {
  std::string name;
  std::string token_digest;   // 32 bytes; empty: it is not enrolled, or was revoked
  std::string code_digest;    // of an open enrolment code; empty: none
  double code_expires_s = 0;  // since the epoch
  double enrolled_s = 0;      // since the epoch; 0: never
  bool revoked = false;
  std::uint64_t rate_kib_s = 0;  // limit of what it may send; 0: none of its own

  bool operator==(const RobotRecord&) const = default;
};

// Writes. Each may be repeated (a robot repeats what was not acknowledged); the repetition has no effect. A keyframe
// that is repeated with other content is refused.
struct PutSession {
  SessionRecord session;
};
/// The session ends before its keyframe `from`. What is stored of it from there on, possibly nothing, becomes `part`,
/// with numbers from 1; earlier merges belong to the first part.
struct SplitSession {
  SessionId session = 0;
  std::uint64_t from = 0;
  SessionRecord part;
};
struct PutKeyframe {
  SessionId session = 0;
  Keyframe keyframe;
};
/// The poses that stored keyframes have now, from the robot's SLAM. They wait until merging takes them over
/// (MovedPoses); until then each_keyframe() returns the earlier poses. `session` is the one that the robot knows;
/// `sessions` holds it and its parts.
struct PutPoses {
  struct OfSession {
    std::uint64_t keyframes = 0;      // that came before the update; later ones are in the frame after it
    std::vector<KeyframePose> poses;  // by rising sequence
  };
  SessionId session = 0;
  std::uint64_t number = 0;
  std::map<SessionId, OfSession> sessions;
};
struct PutCloud {
  KeyframeRef keyframe;
  std::string encoded;
};
/// Deletes clouds for good, to make room; they are not accepted again.
struct LetGo {
  std::vector<KeyframeRef> clouds;
};
struct CompleteSession {
  SessionId session = 0;
};
/// Problems with merging a session. There is no record if there were none.
struct TroubleRecord {
  SessionId session = 0;
  int deaths = 0;         // times that work on it ended the server, hung or failed, since such work last succeeded
  int kills = 0;          // times that the server was killed from outside during such work, since then
  std::string why_aside;  // why it is set aside and not merged; empty: it is not set aside
  bool deleted = false;   // its keyframes and clouds are deleted; the row stays so that its robot can be told

  bool operator==(const TroubleRecord&) const = default;
};
/// Replaces the session's record. deleted: its keyframes, clouds and survey are deleted too.
struct PutTrouble {
  TroubleRecord trouble;
};
/// Archives the session (kept, but left out of everything), or restores it.
struct PutArchived {
  SessionId session = 0;
  bool archived = false;
};
/// Changes the mine in which the session was driven.
struct PutSite {
  SessionId session = 0;
  std::string site;
};
/// The site of sessions that this robot starts from now on; empty: no site.
struct PutRobotSite {
  std::string robot, site;
};
/// Merging has taken over the waiting updates up to this number.
struct MovedPoses {
  SessionId session = 0;
  std::uint64_t number = 0;
  std::vector<KeyframePose> poses;
};
/// The changes of one attempt or decision, in one transaction.
struct PutMerge {
  SessionId attempted = 0;  // 0: none
  std::uint64_t attempted_keyframes = 0;
  std::vector<Alignment> changed;
  std::optional<Atlas> atlas;                            // a new revision
  std::vector<DecisionRecord> decided;                   // new ones, and those that were undone
  SessionId anchored = 0;                                // chosen as its component's anchor; 0: none
  std::map<SessionId, SelfLikeness> self_likeness = {};  // replaces earlier records
  bool attempted_whole = false;
  std::vector<PairClosures> closures = {};  // replace those of the pairs
  std::vector<FrozenSession> frozen = {};   // replace those of their sessions
  SessionId thawed = 0;                     // a session that is no longer frozen; 0: none
  std::optional<PutTrouble> trouble = {};   // this and the following, with their effects on the atlas
  std::optional<PutArchived> archived = {};
  std::optional<PutSite> site = {};
  std::optional<MovedPoses> moved = {};
};
/// The operator's name for a session; empty: none.
struct PutLabel {
  SessionId session = 0;
  std::string label;
};
/// The operator's note on a session; empty: none.
struct PutSessionNote {
  SessionId session = 0;
  std::string note;
};
/// Replaces the session's survey and makes it the one set last.
struct PutSurvey {
  Survey survey;
};
struct DropSurvey {
  SessionId session = 0;
};
struct PutRobot {
  RobotRecord robot;
};
using Write = std::variant<PutSession, SplitSession, PutKeyframe, PutCloud, CompleteSession, PutMerge, PutRobot,
                           PutLabel, PutSurvey, DropSurvey, PutTrouble, PutSessionNote, LetGo, PutRobotSite, PutPoses>;

struct StoreLoad {
  std::size_t queued_writes = 0;
  std::size_t queued_bytes = 0;
  std::uint64_t durable_writes = 0;
  std::uint64_t failed_writes = 0;
  std::uint64_t commits = 0;
  double commit_s = 0;                // total time until commits were durable
  std::size_t queue_bytes = 0;        // limit of queued bytes
  std::size_t damaged_keyframes = 0;  // rows found that are not what was written
  std::string last_error;             // empty if the last write succeeded
  std::string waits_for;              // why the next write is delayed; empty: it is not; it is retried
  std::string broken;                 // why nothing can be written until the store is reopened; empty: it can
};

/// Updates of poses of one session that merging has not taken over yet.
struct NewPoses {
  std::uint64_t number = 0;         // the newest update; 0: none waits
  std::uint64_t keyframes = 0;      // number that came before the first of them
  std::vector<KeyframePose> poses;  // by rising sequence
};

struct CloudSize {
  std::uint64_t sequence = 0;
  std::uint64_t bytes = 0;
};

struct StoredMerge {
  std::vector<Alignment> alignments;      // ordered by id
  Atlas atlas;                            // the last revision
  std::vector<DecisionRecord> decisions;  // ordered by id
  std::vector<SessionId> anchors;         // in the order they were chosen
  std::map<SessionId, SelfLikeness> self_likeness = {};
  std::vector<PairClosures> closures = {};
  std::vector<FrozenSession> frozen = {};  // ordered by session
};

struct StoredNotes {
  std::map<SessionId, std::string> labels;
  std::vector<Survey> surveys;  // in the order they were set
  std::map<SessionId, std::string> notes = {};
};

/// All calls are thread safe.
class Store {
 public:
  using Done = std::function<void(const Result<void>&)>;

  /// Finishes queued writes.
  virtual ~Store() = default;

  /// Never blocks. `done` is called once: on the writer's thread after the durable commit or the failure, or at once if
  /// the queue is full (unavailable); it must be fast. A full or slow disk, or an unreachable database, is not a
  /// failure: the write waits. Writes are applied in the order of the calls, except that LetGo goes before writes that
  /// wait for room. A keyframe that would leave a gap in its session's sequence fails. invalid_argument and refused
  /// (another keyframe with this number is stored) concern only this write; bad_input and internal mean that the
  /// database can no longer be written, and from then on every write fails.
  virtual void write(Write write, Done done) = 0;
  virtual StoreLoad load() const = 0;

  /// Whether the database is unreachable: then reads fail (unavailable) and may be repeated unchanged when it is back.
  virtual bool is_away() = 0;

  // Reads block on the disk: never call them on an I/O thread.
  virtual Result<std::vector<SessionRecord>> sessions() = 0;
  /// Keyframes from sequence `first` on, in order, with the poses that merging uses. A keyframe whose row is damaged
  /// keeps its number, gets the pose of the intact one before it (or else after it) and has no walls, descriptor or
  /// cloud.
  virtual Result<void> each_keyframe(SessionId session, std::uint64_t first,
                                     const std::function<void(Keyframe)>& visit) = 0;
  virtual Result<NewPoses> new_poses(SessionId session) = 0;
  /// Number of keyframes, which is the last sequence; 0: none.
  virtual Result<std::uint64_t> last_keyframe(SessionId session) = 0;
  virtual Result<std::vector<std::uint64_t>> cloud_sequences(SessionId session) = 0;
  /// The size of each stored cloud.
  virtual Result<std::vector<CloudSize>> cloud_sizes(SessionId session) = 0;
  /// Clouds that were deleted to make room, in order.
  virtual Result<std::vector<std::uint64_t>> let_go(SessionId session) = 0;
  /// How much more can be stored: on the disk and in the database's file, or of StoreOptions::clouds_bytes; nullopt:
  /// unknown.
  virtual Result<std::optional<std::uint64_t>> free_bytes() = 0;
  /// Encoded as the robot sent it; not_found: there is none, or its keyframe's row is damaged.
  virtual Result<std::string> cloud(const KeyframeRef& keyframe) = 0;
  virtual Result<StoredMerge> merge() = 0;
  virtual Result<StoredNotes> notes() = 0;
  virtual Result<std::vector<RobotRecord>> robots() = 0;
  /// The robots that have a site.
  virtual Result<std::map<std::string, std::string>> robot_sites() = 0;
  virtual Result<std::vector<TroubleRecord>> troubles() = 0;

  /// Makes a file in the data directory with everything that is durable now and with the server's identity
  /// (backup.hpp); the caller removes it. Writes continue meanwhile. unavailable: the disk failed, or another backup is
  /// in progress; refused: PostgreSQL is backed up with its own tools.
  virtual Result<std::filesystem::path> backup() = 0;
};

}  // namespace headframe
