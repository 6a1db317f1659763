#pragma once
// The interface of the robot library: scans with poses in, the transform of the robot's map out. No ROS, no PCL.

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

/// Describes the descriptors that the robot computes itself and passes to add_keyframe.
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
  std::vector<Endpoint> more_servers;  // standby servers: tried in turn, with the same credential
  std::filesystem::path credential;    // file, of this robot alone; empty: ROBOT.credential beside the spool
  std::string enrolment;               // what `headframe robot add` printed; used only once, and may stay set
  std::string fingerprint;             // hexadecimal, of the server to trust; empty: the one of the enrolment
  bool insecure = false;               // plain TCP without credential, for a server that runs with --insecure
  Sensor sensor;

  std::string family{default_family_name};        // of add_scan: see make_family
  std::optional<OwnDescriptors> own_descriptors;  // set: add_keyframe only
  CloudPolicy clouds = CloudPolicy::all;
  double bytes_per_s = 0;                         // limit of what is sent; 0: none
  std::uint64_t cloud_quota_bytes = 8ULL << 30U;  // of the spool; the oldest clouds go first
  bool provisional = false;  // also receive merges that still wait for path (Transforms::provisional)
  bool sync = true;          // false: a power cut may take the last seconds
  bool intensity = true;     // false: clouds are sent without intensities, about a seventh smaller
  float min_range_m = 0.1F;  // nearer points are dropped
  KeyframeConfig keyframes;
  SweepConfig sweeps;
};

/// add_scan, add_keyframe, update_poses and correct must be called from one thread at a time, and a session uses either
/// add_scan or add_keyframe. All other functions are thread safe.
class RobotClient {
 public:
  /// Opens the spool, resuming its session if there is one, and starts connecting. The server need not be reachable.
  static Result<std::unique_ptr<RobotClient>> open(const RobotConfig& config);

  /// Adds one scan in the sensor frame. Returns true if it became a keyframe; it is then on the disk, for which the
  /// call blocks (a few milliseconds, more when the disk stalls). Stamps have to rise: a scan whose stamp is not after
  /// the last keyframe in the spool is ignored, so that a repeated recording, or a driver that repeats itself, resumes.
  /// A fault of kind invalid_argument or bad_input loses only this scan; unavailable means that the disk failed.
  /// intensity: one value for each point, or none: the strength of its return in the sensor's own scale, to 1, 255 or
  /// 65535, which is detected (see IntensityScale). It appears in exports; merging ignores it.
  Result<bool> add_scan(double stamp_s, const Pose& T_local_sensor, const Points& points_sensor,
                        const std::vector<float>& intensity = {});

  /// Adds a keyframe that the robot chose and described itself; points may be empty (no cloud). q and w must have the
  /// sizes given in own_descriptors. Returns false if its stamp is not after the last keyframe's.
  Result<bool> add_keyframe(double stamp_s, const Pose& T_local_sensor, const Descriptor& descriptor,
                            const Points& points_sensor, const std::vector<float>& intensity = {});

  /// After SLAM closed a loop: sets new poses, in the session's local frame, of keyframes that were added before.
  /// Keyframes that are not named stay. When the call returns, all of it or none is on the disk. It is sent after all
  /// keyframes that exist now and before later ones, so whatever is added from here on has to be in the corrected
  /// frame. The sweeps since the last keyframe are dropped. A server that does not support updates gets none: they wait
  /// in the spool for a newer server (Progress::pose_updates_unsupported). Fails with invalid_argument if a keyframe
  /// does not exist or is named twice, a pose is not finite or beyond 1e8 m, there are no poses or more than 100 000,
  /// or the session is finished; with unavailable if the disk failed.
  Result<void> update_poses(std::span<const KeyframePose> poses);

  /// The same from a whole trajectory of the sensor, as SLAM gives it after a loop closure. Keyframes that moved far
  /// enough are updated; those without a pose in the trajectory move with their neighbours (corrected_keyframes).
  /// Returns the updated keyframes and how many had a pose; if none had, no stamp matches and nothing is moved. Fails
  /// like update_poses, except when nothing moved; also with invalid_argument for stamps that do not rise or numbers
  /// that are not finite.
  Result<CorrectedKeyframes> correct(std::span<const TrajectoryPose> trajectory, const CorrectionRules& rules = {});

  /// The number of the last keyframe, for update_poses: keyframes are numbered from 1. 0: there is none yet.
  std::uint64_t last_keyframe() const;

  /// Sets the function that is called on the link's thread when transforms change, and at once, on the calling thread,
  /// if some are known. It must not throw, block or call close(). It replaces the one set before.
  void on_transform(const std::function<void(const Transforms&)>& callback);
  std::optional<Transforms> transforms() const;

  /// Asks where the robot is in the map of others, from now on, also after reconnections. The callback gets each
  /// answer: at once what is known, then whenever that changes, every few metres while the robot drives. It is called
  /// on the link's thread, with the same rules as for on_transform; it replaces the one set before. An empty function
  /// ends the question. Nothing is merged because of the question, and an answer that is withdrawn comes as `not_yet`.
  void localize(const std::function<void(const Localization&)>& callback);

  /// Asks for the paths of the other sessions of the robot's component, from now on, also after reconnections. The
  /// callback gets all of them, in the robot's local frame: at once, and again whenever there is something new. It is
  /// called on the link's thread, with the same rules as for on_transform; it replaces the one set before. An empty
  /// function ends the question.
  void trajectories(const std::function<void(const Trajectories&)>& callback);

  /// The same for what was seen of the component from above: so that nobody maps a place twice.
  void coverage(const std::function<void(const Coverage&)>& callback);

  /// Asks once for the points that all sessions have around a place. The callback gets one answer, in the robot's local
  /// frame, on the link's thread: a map, or why there is none. There is one question at a time: a later one replaces
  /// the one before, which is then not answered.
  void map_around(const MapQuestion& question, const std::function<void(const MapAround&)>& callback);

  /// Sets what operators see of the robot beside its map: where it is, its battery, a line on its health (256 bytes).
  /// The newest state is sent at most once a second, every five seconds if nothing changed, until finish(); it is not
  /// stored. add_scan and add_keyframe report the pose by themselves, and a state without a pose leaves it unchanged.
  /// Fails with invalid_argument for a number that is not finite, or a battery outside 0 to 1.
  Result<void> live(const LiveState& state);

  /// Asks the server to merge now.
  void trigger(const std::string& reason);

  SessionKey session() const;
  /// What opening the spool found and repaired; and, once it happened, that scans are unlike those the descriptor was
  /// made for.
  std::vector<std::string> warnings() const;
  Progress progress() const;

  /// Ends the session: waits until every keyframe (and with the policy `all` every cloud) is acknowledged, then asks
  /// the server to merge. Fails with the link's last error after `patience` without progress, or at once when the
  /// server refused the robot. Nothing is lost then: open the same spool again. `each_step` is called about five times
  /// a second.
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
