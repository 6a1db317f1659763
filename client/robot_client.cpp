#include "client/robot_client.hpp"

#include <cmath>
#include <mutex>
#include <utility>

#include "client/robot_identity.hpp"
#include "client/spooled_link.hpp"
#include "client/uplink/uplink.hpp"
#include "common/cloud/cloud_codec.hpp"
#include "common/cloud/intensity_scale.hpp"
#include "common/descriptor/family.hpp"
#include "common/descriptor/level.hpp"
#include "common/descriptor/wall_profile.hpp"

namespace headframe {

// The robot's data flow:
//   scan + pose -> selector -> descriptor, walls, sweeps -> spool -> uplink -> base station
//   base station -> acks -> spool; transforms -> callback
struct RobotClient::State {
  State(RobotConfig c, std::unique_ptr<DescriptorFamily> f, Spool spool)
      : config(std::move(c)),
        family(std::move(f)),
        selector(config.keyframes),
        sweeps(config.sweeps),
        link(std::move(spool)),
        sequence(link.last_sequence()) {}

  Result<void> restore_keyframes();
  void note_moved(std::span<const KeyframePose> poses);
  void on_event(const UplinkEvent& event);
  Result<bool> judge(double stamp_s, const Pose& T_local_sensor) const;
  Result<Returns> usable(const Points& points_sensor, const std::vector<float>& intensity);
  Result<bool> spool_keyframe(Keyframe keyframe, const Returns& scan_sensor, const Points& points_level);
  void warn_of(const Points& points_level);

  const RobotConfig config;
  const std::unique_ptr<DescriptorFamily> family;  // null with own descriptors
  KeyframeSelector selector;
  IntensityScale intensity_scale;
  std::atomic<bool> finished{false};
  SweepCollector sweeps;
  SpooledLink link;
  std::optional<CredentialFile> credential;  // used on the uplink's thread; none: unencrypted
  std::uint64_t sequence = 0;                // of the last keyframe
  std::vector<KnownKeyframe> keyframes;      // all of them, with their present poses
  std::mutex unfamiliar_mutex;
  std::string unfamiliar;          // the family's remark on the first scan that it was not made for
  std::unique_ptr<Uplink> uplink;  // last: its thread uses `link`
};

Result<std::unique_ptr<RobotClient>> RobotClient::open(const RobotConfig& config) {
  if (auto ok = check_name("robot", config.robot); !ok) return failure(ErrorCode::invalid_argument, ok.error().message);
  std::unique_ptr<DescriptorFamily> family;
  if (!config.own_descriptors) {
    auto made = make_family(config.family);
    if (!made) return tl::unexpected(made.error());
    family = std::move(*made);
  }
  std::optional<CredentialFile> credential;
  const auto link = link_of(config, credential);
  if (!link) return tl::unexpected(link.error());
  const Hello hello = hello_of(config, family.get());
  auto spool = Spool::open({config.spool, config.cloud_quota_bytes, config.sync}, hello);
  if (!spool) return tl::unexpected(spool.error());

  auto state = std::make_unique<State>(config, std::move(family), std::move(*spool));
  if (auto ok = state->restore_keyframes(); !ok) return tl::unexpected(ok.error());
  Hello shown = state->link.identity();
  if (credential) {
    shown.token = credential->credential().token;
    shown.enrolment_code = credential->credential().code;
  }
  state->credential = std::move(credential);
  state->uplink = std::make_unique<Uplink>(*link, shown, state->link,
                                           [s = state.get()](const UplinkEvent& event) { s->on_event(event); });
  return std::unique_ptr<RobotClient>(new RobotClient(std::move(state)));
}

void RobotClient::State::on_event(const UplinkEvent& event) {
  // If the code could not be erased, it is sent once more next time, which is harmless.
  if (credential && std::holds_alternative<Welcomed>(event)) (void)credential->confirmed();
  link.on_event(event);
}

/// Reads the keyframes from the spool, with their present poses.
Result<void> RobotClient::State::restore_keyframes() {
  keyframes.reserve(sequence);
  for (std::uint64_t s = 1; s <= sequence; ++s) {
    const auto keyframe = link.keyframe(s);
    if (!keyframe) return tl::unexpected(keyframe.error());
    keyframes.push_back({keyframe->stamp_s, keyframe->T_local_sensor, keyframe->spaciousness_m});
  }
  const auto moved = link.poses(1, link.last_pose_update());
  if (!moved) return tl::unexpected(moved.error());
  note_moved(*moved);
  return {};
}

/// Continues the selection with the keyframes' present poses. The sweeps since the last keyframe are lost; they cover
/// at most the distance between two keyframes.
void RobotClient::State::note_moved(std::span<const KeyframePose> poses) {
  for (const KeyframePose& pose : poses) keyframes.at(pose.sequence - 1).T_local_sensor = pose.T_local_sensor;
  if (keyframes.empty() || !family) return;  // a robot that chooses its own keyframes needs neither selector nor sweeps
  if (selector.size() == keyframes.size()) {
    selector.move(poses, keyframes.back().spaciousness_m);
  } else {  // after a start, or if the selector chose one that could not be written
    selector = KeyframeSelector(config.keyframes);
    for (const KnownKeyframe& k : keyframes) selector.restore(k.T_local_sensor, k.spaciousness_m);
  }
  (void)sweeps.take(keyframes.back().T_local_sensor, {});
}

/// Returns false if the stamp is not after that of the last keyframe.
Result<bool> RobotClient::State::judge(double stamp_s, const Pose& T_local_sensor) const {
  if (!std::isfinite(stamp_s) || !T_local_sensor.matrix().allFinite())
    return failure(ErrorCode::invalid_argument, "a stamp or pose that is not finite");
  if (finished) return failure(ErrorCode::invalid_argument, "the session is finished");
  return keyframes.empty() || stamp_s > keyframes.back().stamp_s;
}

/// The points that are real returns, with their scaled intensities.
Result<Returns> RobotClient::State::usable(const Points& points_sensor, const std::vector<float>& intensity) {
  if (!intensity.empty() && intensity.size() != points_sensor.size())
    return failure(ErrorCode::invalid_argument, std::to_string(intensity.size()) + " intensities of " +
                                                    std::to_string(points_sensor.size()) + " points");
  return finite_points(points_sensor, config.intensity ? intensity_scale.scaled(intensity) : Intensities{},
                       config.min_range_m);
}

Result<bool> RobotClient::add_scan(double stamp_s, const Pose& T_local_sensor, const Points& points_sensor,
                                   const std::vector<float>& intensity) {
  State& s = *state_;
  if (!s.family) return failure(ErrorCode::invalid_argument, "add_scan with own descriptors: use add_keyframe");
  auto fresh = s.judge(stamp_s, T_local_sensor);
  if (!fresh || !*fresh) return fresh;
  s.link.say_pose(stamp_s, T_local_sensor);
  const auto scan = s.usable(points_sensor, intensity);
  if (!scan) return tl::unexpected(scan.error());
  const Points& points = scan->points;
  if (points.empty()) return failure(ErrorCode::bad_input, "a scan without a usable point");

  const auto decision = s.selector.add(T_local_sensor, mean_range_m(points));
  if (!decision.keyframe) {
    s.sweeps.add(T_local_sensor, points, scan->intensity);
    return false;
  }
  const Points points_level = level(T_local_sensor, points);
  auto descriptor = s.family->extract(points_level);
  if (!descriptor) return tl::unexpected(descriptor.error());
  s.warn_of(points_level);
  Keyframe keyframe;
  keyframe.stamp_s = stamp_s;
  keyframe.T_local_sensor = T_local_sensor;
  keyframe.spaciousness_m = decision.spaciousness_m;
  keyframe.descriptor = std::move(*descriptor);
  return s.spool_keyframe(std::move(keyframe), *scan, points_level);
}

/// Only until the first remark, since one is enough.
void RobotClient::State::warn_of(const Points& points_level) {
  {
    const std::lock_guard lock(unfamiliar_mutex);
    if (!unfamiliar.empty()) return;
  }
  std::string what = family->unfamiliar(points_level);
  const std::lock_guard lock(unfamiliar_mutex);
  unfamiliar = std::move(what);
}

Result<bool> RobotClient::add_keyframe(double stamp_s, const Pose& T_local_sensor, const Descriptor& descriptor,
                                       const Points& points_sensor, const std::vector<float>& intensity) {
  State& s = *state_;
  const auto& own = s.config.own_descriptors;
  if (!own || descriptor.q.size() != own->q_size || descriptor.w.size() != own->w_size)
    return failure(ErrorCode::invalid_argument, "add_keyframe: q and w must have the sizes stated in own_descriptors");
  auto fresh = s.judge(stamp_s, T_local_sensor);
  if (!fresh || !*fresh) return fresh;
  s.link.say_pose(stamp_s, T_local_sensor);
  const auto scan = s.usable(points_sensor, intensity);
  if (!scan) return tl::unexpected(scan.error());
  Keyframe keyframe;
  keyframe.stamp_s = stamp_s;
  keyframe.T_local_sensor = T_local_sensor;
  keyframe.spaciousness_m = mean_range_m(scan->points);
  keyframe.descriptor = descriptor;
  return s.spool_keyframe(std::move(keyframe), *scan, level(T_local_sensor, scan->points));
}

Result<bool> RobotClient::State::spool_keyframe(Keyframe keyframe, const Returns& scan_sensor,
                                                const Points& points_level) {
  keyframe.sequence = sequence + 1;
  keyframe.walls = wall_profile(points_level);
  const KeyframeCloud cloud = sweeps.take(keyframe.T_local_sensor, scan_sensor.points, scan_sensor.intensity);
  std::string encoded;
  const std::size_t count = point_count(cloud);
  if (count > 0 && config.clouds != CloudPolicy::never) {
    auto bytes = encode_cloud(cloud);
    if (!bytes) return tl::unexpected(bytes.error());
    encoded = std::move(*bytes);
    keyframe.point_count = static_cast<std::uint32_t>(count);
  }
  if (auto ok = link.append(keyframe, encoded); !ok) return tl::unexpected(ok.error());
  sequence = keyframe.sequence;
  keyframes.push_back({keyframe.stamp_s, keyframe.T_local_sensor, keyframe.spaciousness_m});
  uplink->wake();
  return true;
}

Result<void> RobotClient::update_poses(std::span<const KeyframePose> poses) {
  State& s = *state_;
  if (s.finished) return failure(ErrorCode::invalid_argument, "the session is finished");
  if (auto ok = s.link.update_poses({poses.begin(), poses.end()}); !ok) return ok;
  s.uplink->wake();
  s.note_moved(poses);
  return {};
}

Result<CorrectedKeyframes> RobotClient::correct(std::span<const TrajectoryPose> trajectory,
                                                const CorrectionRules& rules) {
  auto found = corrected_keyframes(state_->keyframes, trajectory, rules);
  if (!found || found->moved.empty()) return found;
  if (auto ok = update_poses(found->moved); !ok) return tl::unexpected(ok.error());
  return found;
}

std::uint64_t RobotClient::last_keyframe() const { return state_->link.last_sequence(); }

Result<void> RobotClient::finish(std::chrono::milliseconds patience,
                                 const std::function<void(const Progress&)>& each_step) {
  using Clock = std::chrono::steady_clock;
  state_->finished = true;
  state_->link.say(std::nullopt);
  auto last = progress();
  auto moved = Clock::now();
  while (true) {
    const Progress now = progress();
    if (each_step) each_step(now);
    if (state_->link.all_acknowledged()) {
      trigger("session finished");
      return {};
    }
    if (now.refused) return failure(ErrorCode::refused, now.link_error);
    if ((now.connected && now.bytes_sent != last.bytes_sent) ||
        now.keyframes_acknowledged != last.keyframes_acknowledged ||
        now.pose_updates_acknowledged != last.pose_updates_acknowledged || now.clouds_waiting != last.clouds_waiting)
      moved = Clock::now();
    last = now;
    if (Clock::now() - moved >= patience)
      return failure(ErrorCode::unavailable,
                     now.link_error.empty() ? "the server acknowledges nothing" : now.link_error);
    state_->link.wait(std::chrono::milliseconds(200));
  }
}

void RobotClient::on_transform(const std::function<void(const Transforms&)>& callback) {
  state_->link.on_transform(callback);
}
std::optional<Transforms> RobotClient::transforms() const { return state_->link.transforms(); }
void RobotClient::localize(const std::function<void(const Localization&)>& callback) {
  state_->link.on_localization(callback);
  state_->uplink->localize(static_cast<bool>(callback));
}
void RobotClient::trajectories(const std::function<void(const Trajectories&)>& callback) {
  state_->link.on_trajectories(callback);
  state_->uplink->trajectories(static_cast<bool>(callback));
}
void RobotClient::coverage(const std::function<void(const Coverage&)>& callback) {
  state_->link.on_coverage(callback);
  state_->uplink->coverage(static_cast<bool>(callback));
}
void RobotClient::map_around(const MapQuestion& question, const std::function<void(const MapAround&)>& callback) {
  state_->link.on_map(callback);
  state_->uplink->map_around(question);
}
Result<void> RobotClient::live(const LiveState& state) {
  if (auto sound = from_proto(to_proto(state)); !sound)
    return failure(ErrorCode::invalid_argument, "live: " + sound.error().message);
  if (!state_->finished) state_->link.say(state);
  return {};
}
void RobotClient::trigger(const std::string& reason) { state_->uplink->trigger(reason); }
SessionKey RobotClient::session() const { return state_->link.identity().session; }

std::vector<std::string> RobotClient::warnings() const {
  std::vector<std::string> all = state_->link.warnings();
  const std::lock_guard lock(state_->unfamiliar_mutex);
  if (!state_->unfamiliar.empty()) all.push_back(state_->unfamiliar);
  return all;
}

Progress RobotClient::progress() const {
  Progress p = state_->link.progress();
  p.bytes_sent = state_->uplink->bytes_sent();
  p.connected = state_->uplink->connected();
  return p;
}

void RobotClient::close() { state_->uplink->close(state_->finished && state_->link.all_acknowledged()); }

RobotClient::RobotClient(std::unique_ptr<State> state) : state_(std::move(state)) {}
RobotClient::~RobotClient() { close(); }

}  // namespace headframe
