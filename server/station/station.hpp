#pragma once
// What the operator API may see and do. map_merge_server implements it; the HTTP room knows nothing else of the server.

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
  Corrections corrections = {};          // of sessions that the pose graph bends
};

/// What the server has done and what waits for the disk, since it began.
struct Workload {
  std::size_t queued_writes = 0;
  std::size_t queued_bytes = 0;
  std::uint64_t durable_writes = 0;
  std::uint64_t failed_writes = 0;
  std::string disk_error;  // empty when the last write was well
  MergeEffort effort;
  std::uint64_t commits = 0;
  double commit_s = 0;                                    // spent in commits until they were durable
  std::size_t waiting_orders = 0;                         // of the operator, not yet taken up
  std::size_t damaged_keyframes = 0, damaged_clouds = 0;  // found so far: not what was written
  double merge_work_s = 0;       // since the merge worker began the piece of work that it is on; 0: it is on none
  std::string merge_stuck = {};  // why merging counts as stuck; empty: it does not
  std::size_t standbys = 0;      // other servers that wait to take over
};

/// All calls are thread safe and quick, but trajectory(), cloud(), free_bytes() and covered_clouds(), which read from
/// disk: not from an I/O thread.
class Station {
 public:
  virtual ~Station() = default;
  virtual std::vector<SessionRow> sessions() const = 0;
  virtual AtlasView atlas() const = 0;
  virtual Pending pending() const = 0;
  virtual Workload workload() const = 0;
  virtual LinkHealth link_health() const { return {}; }
  /// This server, and those that wait to take over from it.
  virtual std::vector<ServerRecord> servers() const { return {}; }
  virtual MergeConfig merge_config() const = 0;
  /// Calls back once, from any thread, as soon as nothing is pending (at once if so), or when timeout_s is over; with
  /// what is left.
  virtual void when_idle(double timeout_s, std::function<void(Pending)> callback) = 0;
  /// Queues an attempt for every session.
  virtual void merge_all() = 0;
  /// The operator's decision. Calls back once, from any thread, when it is durable and the robots were told, or with
  /// why not: not_found, refused, unavailable.
  virtual void decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> callback) = 0;
  /// b lies so on a, roughly: registered and judged. Calls back as decide(), with what came of it.
  virtual void place(SessionId a, SessionId b, const Pose& T_a_b,
                     std::function<void(const Result<HandPlacement>&)> callback) = 0;
  /// The operator's name for a session. Calls back once, from any thread, when it is durable, or with why not:
  /// not_found, invalid_argument, unavailable.
  virtual void rename(SessionId session, const std::string& label,
                      std::function<void(const Result<void>&)> callback) = 0;
  /// The session's frame becomes its component's. Calls back as decide().
  virtual void anchor(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  /// Asks the session's robot for the clouds that are not here; calls back once with how many, or with why not:
  /// not_found, refused (the robot is away, or sends none), unavailable.
  virtual void request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> callback) = 0;
  /// The session is left out of merging, for the reason given, until it is released; what is stored of it stays, but
  /// for remove(), which deletes it for good. Call back as rename(); refused: it is not set aside.
  virtual void set_aside(SessionId session, const std::string& why,
                         std::function<void(const Result<void>&)> callback) = 0;
  virtual void release(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  virtual void remove(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  /// The session is kept and left out of everything, or comes back as it was; nothing moves it any more, or it may be
  /// moved again. Call back as rename(); refused: it is so already, or can not be.
  virtual void archive(SessionId session, bool archived, std::function<void(const Result<void>&)> callback) = 0;
  virtual void freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> callback) = 0;
  /// The session was driven at this site, and is merged with those there alone; sessions that the robot begins from now
  /// on are. Empty: of no site. Call back as rename(); refused: too many robots have one.
  virtual void set_site(SessionId session, const std::string& site,
                        std::function<void(const Result<void>&)> callback) = 0;
  virtual void set_robot_site(const std::string& robot, const std::string& site,
                              std::function<void(const Result<void>&)> callback) = 0;
  /// Of the robots that have one.
  virtual std::map<std::string, std::string> robot_sites() const = 0;
  /// What is to be remembered of the session. Calls back as rename().
  virtual void note(SessionId session, const std::string& note, std::function<void(const Result<void>&)> callback) = 0;
  /// Where sessions lie in the mine's grid, the one set last at the end.
  virtual std::vector<Survey> surveys() const = 0;
  /// Replaces the session's survey, or takes it away. Call back as rename().
  virtual void set_survey(const Survey& survey, std::function<void(const Result<void>&)> callback) = 0;
  virtual void drop_survey(SessionId session, std::function<void(const Result<void>&)> callback) = 0;
  /// Keyframes in the order of their sequence: stamp and T_local_sensor are filled, the descriptor may be empty.
  virtual Result<std::vector<Keyframe>> trajectory(SessionId session) const = 0;
  /// The stored cloud, in the keyframe's sensor frame; not_found when there is none, or none that can be read: what is
  /// damaged on the disk costs itself and not the map around it, and is logged and counted (Workload).
  virtual Result<KeyframeCloud> cloud(SessionId session, std::uint64_t sequence) const = 0;
  /// As Store::free_bytes().
  virtual Result<std::optional<std::uint64_t>> free_bytes() const = 0;
  /// Which clouds may go so that others find room, the oldest session first. Reads all keyframes that lie in a map.
  virtual Result<std::vector<CoveredClouds>> covered_clouds() const = 0;
  virtual KeepPolicy keep_policy() const = 0;
  /// Deletes these clouds, for good. Calls back as rename(); what went before a failure is gone.
  virtual void let_go(std::vector<CoveredClouds> clouds, std::function<void(const Result<void>&)> callback) = 0;
  /// As Store::backup(): blocks while the database is copied.
  virtual Result<std::filesystem::path> backup() = 0;
};

}  // namespace headframe
