#pragma once
// What the base station keeps: sessions, keyframes, clouds, alignments, revisions; in SQLite or PostgreSQL.

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
  std::uint64_t spool_run = 0;            // the last opening of the spool that was admitted; 0: it does not say
  bool complete = false;                  // the robot said that no keyframe follows
  std::uint64_t attempted_keyframes = 0;  // how many the last finished merge attempt has seen
  bool attempted_whole = false;           // ... and it expected no more: the session had ended, or rested
  bool archived = false;                  // kept, and left out of everything until it is restored
  std::string site = {};                  // the mine it was driven in, by the operator's name; empty: he has one alone
  std::uint64_t pose_update = 0;          // the newest of its robot's that is stored; of a session with parts, of all
};

/// A robot that was let in, or may be. Only digests are kept: SHA-256 of secrets that are random and long.
struct RobotRecord {
  std::string name;
  std::string token_digest;   // 32 bytes; empty: it has not enrolled, or was revoked
  std::string code_digest;    // of the enrolment code that is open; empty: none
  double code_expires_s = 0;  // since the epoch
  double enrolled_s = 0;      // since the epoch; 0: never
  bool revoked = false;
  std::uint64_t rate_kib_s = 0;  // what it may send at most; 0: no limit of its own

  bool operator==(const RobotRecord&) const = default;
};

// Writes. Each may come again (a robot repeats what was not acknowledged): the second time changes nothing. A keyframe
// that comes again with other content is refused.
struct PutSession {
  SessionRecord session;
};
/// The session ends before its keyframe `from`. What is stored of it from there on, which may be nothing, becomes the
/// part's, counted from 1; merges are of what stays.
struct SplitSession {
  SessionId session = 0;
  std::uint64_t from = 0;
  SessionRecord part;
};
struct PutKeyframe {
  SessionId session = 0;
  Keyframe keyframe;
};
/// Where keyframes that are stored lie now, as the robot's SLAM has it. It waits until merging takes it in
/// (MovedPoses); until then each_keyframe() tells the poses of before. Of the session that the robot knows, and its
/// parts.
struct PutPoses {
  struct OfSession {
    std::uint64_t keyframes = 0;      // that came before it: later ones lie in the frame as it is after it
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
/// Deletes clouds for good, so that others find room; they are not taken again.
struct LetGo {
  std::vector<KeyframeRef> clouds;
};
struct CompleteSession {
  SessionId session = 0;
};
/// What came of trying to merge a session. Where nothing was wrong there is none.
struct TroubleRecord {
  SessionId session = 0;
  int deaths = 0;         // work on it that ended the server, hung or failed, since work on it went well
  int kills = 0;          // work on it in which the server was killed from outside, since then
  std::string why_aside;  // it is not merged, and why; empty: it is
  bool deleted = false;   // its keyframes and clouds are gone for good; the row stays so that its robot can be told

  bool operator==(const TroubleRecord&) const = default;
};
/// Replaces the session's. deleted: its keyframes, clouds and survey are deleted with it.
struct PutTrouble {
  TroubleRecord trouble;
};
/// The session is kept and left out of everything, or is so no more.
struct PutArchived {
  SessionId session = 0;
  bool archived = false;
};
/// The session was driven in another mine than was thought.
struct PutSite {
  SessionId session = 0;
  std::string site;
};
/// Where sessions that this robot begins from now on are driven; empty: at no site.
struct PutRobotSite {
  std::string robot, site;
};
/// Merging has taken in what waited, up to this update.
struct MovedPoses {
  SessionId session = 0;
  std::uint64_t number = 0;
  std::vector<KeyframePose> poses;
};
/// What one attempt or decision changed, in one transaction.
struct PutMerge {
  SessionId attempted = 0;  // 0: none
  std::uint64_t attempted_keyframes = 0;
  std::vector<Alignment> changed;
  std::optional<Atlas> atlas;                            // a new revision
  std::vector<DecisionRecord> decided;                   // new ones, and those that were undone
  SessionId anchored = 0;                                // chosen as its component's anchor; 0: none
  std::map<SessionId, SelfLikeness> self_likeness = {};  // replaces what was known
  bool attempted_whole = false;
  std::vector<PairClosures> closures = {};  // they replace those of the pairs
  std::vector<FrozenSession> frozen = {};   // they replace those of their sessions
  SessionId thawed = 0;                     // frozen no more; 0: none
  std::optional<PutTrouble> trouble = {};   // this and the next: with what it does to the atlas
  std::optional<PutArchived> archived = {};
  std::optional<PutSite> site = {};
  std::optional<MovedPoses> moved = {};
};
/// The operator's name for a session; empty: none.
struct PutLabel {
  SessionId session = 0;
  std::string label;
};
/// What the operator wants to be remembered of a session; empty: nothing.
struct PutSessionNote {
  SessionId session = 0;
  std::string note;
};
/// Replaces the session's survey, and counts as the one set last.
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
  double commit_s = 0;                // spent in them, until they were durable
  std::size_t queue_bytes = 0;        // the most that may be queued
  std::size_t damaged_keyframes = 0;  // rows that were read and are not what was written
  std::string last_error;             // empty when the last write was well
  std::string waits_for;              // why the next write can not be made yet; empty: it can. It is tried again
  std::string broken;  // why nothing is written any more, until the store is opened anew; empty: it is well
};

/// What waits until merging takes it in, of one session.
struct NewPoses {
  std::uint64_t number = 0;         // of the newest update; 0: nothing waits
  std::uint64_t keyframes = 0;      // that came before the first of them
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

  /// Finishes what is queued.
  virtual ~Store() = default;

  /// Never blocks. `done` runs once: on the writer's thread after the durable commit or the failure, or at once when
  /// the queue is full (unavailable). A full or slow disk, or a database that is away, is no failure: the write waits.
  /// It must be quick.
  /// Writes are applied in the order of the calls, but LetGo before what waits for room; a keyframe that would leave a
  /// hole in its session's sequence fails. Failures: invalid_argument and refused (another keyframe of this number is
  /// stored) concern this write alone; bad_input and internal say that the database can not be written any more: from
  /// then on every write fails so.
  virtual void write(Write write, Done done) = 0;
  virtual StoreLoad load() const = 0;

  /// The database does not answer: reads fail (unavailable), and may be repeated as they were when it is back.
  virtual bool is_away() = 0;

  // Reads block on the disk: never on an I/O thread.
  virtual Result<std::vector<SessionRecord>> sessions() = 0;
  /// Keyframes from sequence `first` on, in order, where they lie by what merging has taken in. One whose row is
  /// damaged keeps its number, stands where the one before it does and has seen nothing.
  virtual Result<void> each_keyframe(SessionId session, std::uint64_t first,
                                     const std::function<void(Keyframe)>& visit) = 0;
  virtual Result<NewPoses> new_poses(SessionId session) = 0;
  /// How many keyframes it has: the last sequence, 0 without any.
  virtual Result<std::uint64_t> last_keyframe(SessionId session) = 0;
  virtual Result<std::vector<std::uint64_t>> cloud_sequences(SessionId session) = 0;
  /// Of the clouds that are stored, what each takes.
  virtual Result<std::vector<CloudSize>> cloud_sizes(SessionId session) = 0;
  /// Clouds that were let go, in order.
  virtual Result<std::vector<std::uint64_t>> let_go(SessionId session) = 0;
  /// How much more can be stored: on the disk and in the database's file, or of StoreOptions::clouds_bytes; none:
  /// nobody knows.
  virtual Result<std::optional<std::uint64_t>> free_bytes() = 0;
  /// Encoded as the robot sent it; not_found when there is none, or when its keyframe's row was found damaged.
  virtual Result<std::string> cloud(const KeyframeRef& keyframe) = 0;
  virtual Result<StoredMerge> merge() = 0;
  virtual Result<StoredNotes> notes() = 0;
  virtual Result<std::vector<RobotRecord>> robots() = 0;
  /// Of the robots that have one.
  virtual Result<std::map<std::string, std::string>> robot_sites() = 0;
  virtual Result<std::vector<TroubleRecord>> troubles() = 0;

  /// A file with all that is durable now and what robots and operators know the server by (see backup.hpp), in the
  /// data directory; the caller removes it. Writes go on meanwhile. unavailable: the disk says no, or another
  /// backup is being made; refused: PostgreSQL is backed up with its own tools.
  virtual Result<std::filesystem::path> backup() = 0;
};

}  // namespace headframe
