#pragma once
// What the operator API can see and do. Implemented by StationView; the API knows nothing else of the server.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/result.hpp"
#include "common/session/keyframe.hpp"
#include "server/atlas/atlas.hpp"
#include "server/atlas/correction.hpp"
#include "server/atlas/decisions.hpp"
#include "server/atlas/hand_placement.hpp"
#include "server/atlas/survey.hpp"
#include "server/merge/merge_config.hpp"
#include "server/net/link_health.hpp"
#include "server/session/session_row.hpp"
#include "server/station/covered_clouds.hpp"
#include "server/store/server_record.hpp"
#include "server/support/stage_times.hpp"

namespace headframe {

struct AlignmentRow {
  Alignment alignment;
  SessionKey a, b;
};

struct AtlasView {
  Atlas atlas;
  std::vector<AlignmentRow> alignments;  // ordered by id
  Corrections corrections = {};          // for sessions that the pose graph corrects
};

/// What the server has done since it started, and what waits for the disk.
struct Workload {
  std::size_t queued_writes = 0;
  std::size_t queued_bytes = 0;
  std::uint64_t durable_writes = 0;
  std::uint64_t failed_writes = 0;
  std::string disk_error;  // empty if the last write succeeded
  MergeEffort effort;
  std::uint64_t commits = 0;
  double commit_s = 0;                                    // spent in commits until they were durable
  std::size_t waiting_orders = 0;                         // operator's orders not yet started
  std::size_t damaged_keyframes = 0, damaged_clouds = 0;  // found so far
  double merge_work_s = 0;       // since the merge worker started its present piece of work; 0: it has none
  std::string merge_stuck = {};  // why merging counts as stuck; empty: it does not
  std::size_t standbys = 0;      // other servers that are ready to take over
};

/// All calls are thread safe and fast, except trajectory(), cloud(), free_bytes(), covered_clouds() and backup(), which
/// read from the disk and must not be called on an I/O thread.
class Station {
 public:
  virtual ~Station() = default;
  virtual std::vector<SessionRow> sessions() const = 0;
  virtual AtlasView atlas() const = 0;
  virtual Pending pending() const = 0;
  virtual Workload workload() const = 0;
  virtual LinkHealth link_health() const { return {}; }
  /// This server, and the standby servers.
  virtual std::vector<ServerRecord> servers() const { return {}; }
  virtual MergeConfig merge_config() const = 0;
  /// Calls back once, from any thread, with what is pending: as soon as nothing is (at once if so), or after timeout_s.
  virtual void when_idle(double timeout_s, std::function<void(Pending)> callback) = 0;
  /// Queues an attempt for every session.
  virtual void merge_all() = 0;
  /// Applies the operator's decision. Calls back once, from any thread, when it is durable and the robots were told, or
  /// with the failure: not_found, refused, unavailable.
  virtual void decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> callback) = 0;
  /// Places b on a roughly; the placement is registered and judged. Calls back like decide(), with the result.
  virtual void place(SessionId a, SessionId b, const Pose& T_a_b,
                     std::function<void(const Result<HandPlacement>&)> callback) = 0;
  /// Sets the operator's name for a session. Calls back once, from any thread, when it is durable, or with the failure:
  /// not_found, invalid_argument, unavailable.
  virtual void rename(SessionId session, const std::string& label,
                      std::function<void(const Result<void>&)> callback) = 0;
  /// Makes the session's frame the frame of its component. Calls back like decide().
  virtual void anchor(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  /// Requests all missing clouds from the session's robot. Calls back once with their number, or with the failure:
  /// not_found, refused (the robot is not connected, or sends no clouds), unavailable.
  virtual void request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> callback) = 0;
  /// set_aside: leaves the session out of merging, for the given reason, until it is released; its stored data stays.
  /// remove: also deletes the stored data, for good. Call back like rename(); refused: it is not set aside.
  virtual void set_aside(SessionId session, const std::string& why,
                         std::function<void(const Result<void>&)> callback) = 0;
  virtual void release(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  virtual void remove(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  /// archive: keeps the session but leaves it out of everything, or brings it back unchanged. freeze: nothing moves the
  /// session, or it may be moved again. Call back like rename(); refused: it is in this state already, or cannot be.
  virtual void archive(SessionId session, bool archived, std::function<void(const Result<void>&)> callback) = 0;
  virtual void freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> callback) = 0;
  /// Sets the site of a session, or of all sessions that a robot starts from now on; a session is merged only with
  /// those of its site. Empty: no site. Call back like rename(); refused: too many robots have one.
  virtual void set_site(SessionId session, const std::string& site,
                        std::function<void(const Result<void>&)> callback) = 0;
  virtual void set_robot_site(const std::string& robot, const std::string& site,
                              std::function<void(const Result<void>&)> callback) = 0;
  /// The robots that have a site.
  virtual std::map<std::string, std::string> robot_sites() const = 0;
  /// Sets the operator's note on the session. Calls back like rename().
  virtual void note(SessionId session, const std::string& note, std::function<void(const Result<void>&)> callback) = 0;
  /// The sessions' transforms to the mine's grid; the one set last is at the end.
  virtual std::vector<Survey> surveys() const = 0;
  /// Replaces or removes the session's survey. Call back like rename().
  virtual void set_survey(const Survey& survey, std::function<void(const Result<void>&)> callback) = 0;
  virtual void drop_survey(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  /// Keyframes in order of sequence, with stamp and T_local_sensor; the descriptor may be empty.
  virtual Result<std::vector<Keyframe>> trajectory(SessionId session) const = 0;
  /// The stored cloud, in the keyframe's sensor frame. not_found: there is none, or it is damaged; damage affects only
  /// this cloud, and is logged and counted (Workload).
  virtual Result<KeyframeCloud> cloud(SessionId session, std::uint64_t sequence) const = 0;
  /// Like Store::free_bytes().
  virtual Result<std::optional<std::uint64_t>> free_bytes() const = 0;
  /// Which clouds may be deleted to make room, oldest session first. Reads all keyframes of merged sessions.
  virtual Result<std::vector<CoveredClouds>> covered_clouds() const = 0;
  virtual KeepPolicy keep_policy() const = 0;
  /// Deletes these clouds, for good. Calls back like rename(); if it fails, some may already be deleted.
  virtual void let_go(std::vector<CoveredClouds> clouds, std::function<void(const Result<void>&)> callback) = 0;
  /// Like Store::backup(): blocks while the database is copied.
  virtual Result<std::filesystem::path> backup() = 0;
};

}  // namespace headframe
