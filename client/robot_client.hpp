#pragma once
// What a robot developer links: scans with poses in, the transform of the robot's map out. No ROS, no PCL.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/keyframe/corrected_keyframes.hpp"
#include "client/keyframe/keyframe_selector.hpp"
#include "client/keyframe/sweeps.hpp"
#include "client/localization.hpp"
#include "client/progress.hpp"
#include "client/surroundings.hpp"
#include "client/transforms.hpp"
#include "common/cloud/point_cloud.hpp"
#include "common/descriptor/family.hpp"
#include "common/endpoint.hpp"
#include "common/result.hpp"
#include "common/session/cloud_policy.hpp"
#include "common/session/keyframe.hpp"
#include "common/session/keyframe_pose.hpp"
#include "common/session/live_state.hpp"

namespace headframe {

/// Descriptors that the robot computes itself, for add_keyframe.
struct OwnDescriptors {
  FamilyId family;
  std::size_t q_size = 0;
  std::size_t w_size = 0;
};

struct RobotConfig {
  std::string robot;            // its name on the server
  std::string session;          // empty: a random name, made once and kept in the spool
  std::filesystem::path spool;  // directory; one directory is one session (one local frame)
  std::string host;             // of the base station
  std::uint16_t port = 7447;
  std::vector<Endpoint> more_servers;  // that stand by for that one: tried in turn, with the same credential
  std::filesystem::path credential;    // file, of this robot alone; empty: ROBOT.credential beside the spool
  std::string enrolment;               // what `headframe robot add` printed; only its first use counts, it may stay
  std::string fingerprint;             // hexadecimal; pins another server than the enrolment did; empty: that one
  bool insecure = false;               // plain TCP without credential, to a server that runs so: nothing is protected
  Sensor sensor;

  std::string family{default_family_name};        // of add_scan: see make_family
  std::optional<OwnDescriptors> own_descriptors;  // set: add_keyframe only
  CloudPolicy clouds = CloudPolicy::all;
  double bytes_per_s = 0;                         // budget of what is sent; 0: no limit
  std::uint64_t cloud_quota_bytes = 8ULL << 30U;  // of the spool; the oldest clouds go first
  bool provisional = false;  // be told of merges that still wait for path, too (Transforms::provisional)
  bool sync = true;          // false: a power cut may take the last seconds
  bool intensity = true;     // false: clouds go without, which takes about a seventh off their bytes
  float min_range_m = 0.1F;  // nearer points are no returns
  KeyframeConfig keyframes;
  SweepConfig sweeps;
};

/// add_scan, add_keyframe, update_poses and correct: from one thread at a time, and one of the first two only. All else
/// is thread safe.
class RobotClient {
 public:
  /// Opens the spool (resuming its session when there is one) and starts connecting. The server need not be there.
  static Result<std::unique_ptr<RobotClient>> open(const RobotConfig& config);

  /// One scan in the sensor frame. True: it became a keyframe and is on the disk. Blocks for the disk then (a few
  /// milliseconds; more when it stalls). Stamps go up; a scan whose stamp is not after the last keyframe in the spool
  /// adds nothing: that is how a recording, or a driver that repeats itself, resumes. A fault (invalid_argument,
  /// bad_input) loses this scan alone; unavailable is the disk's.
  /// Intensity: as many as points, or none; how strong their returns were, as the sensor says it, on a scale to 1, to
  /// 255 or to 65535, which is found out (see IntensityScale). Surveyors see it in exports; nothing else rests on it.
  Result<bool> add_scan(double stamp_s, const Pose& T_local_sensor, const Points& points_sensor,
                        const std::vector<float>& intensity = {});

  /// A keyframe that the robot chose and described itself; points may be empty (no cloud). q and w must have the sizes
  /// of own_descriptors. False: its stamp is not after the last keyframe's.
  Result<bool> add_keyframe(double stamp_s, const Pose& T_local_sensor, const Descriptor& descriptor,
                            const Points& points_sensor, const std::vector<float>& intensity = {});

  /// SLAM moved the past (it closed a loop): these keyframes, which were added before, lie elsewhere in the session's
  /// local frame now. Those that are not named stay. On the disk when it returns, all of them or none; sent after the
  /// keyframes that there are by now and before those that come. What is added from here on has to be in the frame as
  /// it is now. The sweeps since the last keyframe are dropped. A server that is older than this is told nothing of it
  /// (Progress::pose_updates_unsupported): it waits in the spool for a newer one. invalid_argument: no such keyframe,
  /// one that is named twice, a pose that is not finite or beyond 1e8 m, none or more than 100 000, or the session is
  /// finished; unavailable: the disk's.
  Result<void> update_poses(std::span<const KeyframePose> poses);

  /// The same from a whole trajectory of the sensor, as SLAM gives it after a loop closure: keyframes that moved by
  /// enough are updated, and those that it has no pose for move as those around them (corrected_keyframes). Gives which
  /// they are, and how many it had a pose for: none, then no stamp agrees and nothing is moved. Fails as update_poses,
  /// but not where nothing moved; invalid_argument: stamps that do not rise, or what is not finite.
  Result<CorrectedKeyframes> correct(std::span<const TrajectoryPose> trajectory, const CorrectionRules& rules = {});

  /// Which number the last keyframe has; 0: there is none. For update_poses: they are numbered from 1.
  std::uint64_t last_keyframe() const;

  /// Called when transforms change, on the link's thread, and at once when some are known. It must not throw, block or
  /// call close(). The last one set counts.
  void on_transform(const std::function<void(const Transforms&)>& callback);
  std::optional<Transforms> transforms() const;

  /// Asks where the robot is in the map of others, from now on, over connections to come too. The callback gets each
  /// answer: at once what is known, then whenever that changes, while the robot drives after every few metres. It is
  /// called on the link's thread, like on_transform's; the last one set counts. None: asks no more. Nothing is merged
  /// for the question, and an answer that is withdrawn comes as `not_yet`.
  void localize(const std::function<void(const Localization&)>& callback);

  /// Asks for the paths of the other sessions of the robot's component, from now on, over connections to come too. The
  /// callback gets all of them, in the robot's local frame: at once, and again whenever there is something new. It is
  /// called on the link's thread, like on_transform's; the last one set counts. None: asks no more.
  void trajectories(const std::function<void(const Trajectories&)>& callback);

  /// The same for what was seen of the component from above: where not to go any more.
  void coverage(const std::function<void(const Coverage&)>& callback);

  /// Asks once for the points that all sessions have around here. The callback gets the one answer, in the robot's
  /// local frame, on the link's thread: a map, or why there is none. One is asked for at a time: a later question takes
  /// the place of the one before, which is not answered any more.
  void map_around(const MapQuestion& question, const std::function<void(const MapAround&)>& callback);

  /// What people at the base station see of the robot beside its map: where it is, its battery, a line on its health
  /// (256 bytes). The newest state is sent, each second at most, every five where nothing changed, until finish();
  /// nothing of it is stored. add_scan and add_keyframe say the pose by themselves, and a state without one leaves it.
  /// invalid_argument: a number that is none, or a battery outside 0 to 1.
  Result<void> live(const LiveState& state);

  /// Asks the server to merge now.
  void trigger(const std::string& reason);

  SessionKey session() const;
  /// What opening the spool found and cured; and, once a scan was so, that scans are unlike those the family was made
  /// for.
  std::vector<std::string> warnings() const;
  Progress progress() const;

  /// The session has ended: waits until every keyframe (and with the policy `all` every cloud) is acknowledged, then
  /// asks the server to merge. Fails with the link's last error after `patience` without progress, or at once when
  /// refused. Nothing is lost then: open the same spool again. `each_step` is called about five times a second.
  Result<void> finish(std::chrono::milliseconds patience, const std::function<void(const Progress&)>& each_step = {});

  /// Says goodbye (complete after a finish() that succeeded) and stops the link.
  void close();

  ~RobotClient();  // close()

 private:
  struct State;
  explicit RobotClient(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace headframe
