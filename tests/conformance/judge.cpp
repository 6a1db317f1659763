#include "tests/conformance/judge.hpp"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/cloud/cloud_codec.hpp"
#include "common/descriptor/level.hpp"
#include "common/descriptor/wall_profile.hpp"
#include "common/security/secret.hpp"
#include "common/wire/capabilities.hpp"
#include "common/wire/frame_codec.hpp"

namespace headframe::conformance {
namespace {

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", v);
  return text;
}

/// The greatest difference, as a share of the largest number (at least 1) of b.
double farthest(const std::vector<float>& a, const std::vector<float>& b) {
  float most = 0, largest = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    most = std::max(most, std::abs(a[i] - b[i]));
    largest = std::max(largest, std::abs(b[i]));
  }
  return static_cast<double>(most / largest);
}

/// Of a cloud's points, the share within `near_m` of some of the scan's (of some hundred that are looked at).
double share_near(const Points& points, const Points& scan, float near_m) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / 200);
  std::size_t looked_at = 0, near = 0;
  for (std::size_t i = 0; i < points.size(); i += step, ++looked_at)
    near += std::any_of(scan.begin(), scan.end(),
                        [&](const auto& p) { return (p - points[i]).squaredNorm() < near_m * near_m; });
  return looked_at == 0 ? 0 : static_cast<double>(near) / static_cast<double>(looked_at);
}

}  // namespace

void Judge::hello(const v1::Hello& hello) {
  findings_.check(hello.protocol_version() == protocol_version, "version",
                  "the hello states protocol_version " + std::to_string(hello.protocol_version()) + ", not 1");
  const auto read = from_proto(hello);
  if (!read) return findings_.wrong("hello-field", "the hello is refused: " + read.error().message);
  policy_ = read->clouds;
  family_ = read->family;
  if (auto family = make_family(family_.id.name)) known_ = std::move(*family);
  findings_.check(read->session.robot == given_.robot, "robot",
                  "the hello names robot " + read->session.robot + ", not " + given_.robot);
  findings_.check(!read->spare, "spare", "the hello is a spare's, though no Welcome allowed one");
  findings_.check(static_cast<std::size_t>(hello.capabilities_size()) == read->capabilities.size(), "capabilities",
                  "a capability is no name of 1 to 32 of a-z, 0-9 and _, or there are more than 64");
  identity(hello);
}

/// What makes it the same robot with the same session on every connection.
void Judge::identity(const v1::Hello& hello) {
  findings_.check(hello.token().size() == token_bytes, "token", "under TLS every hello carries a token of 32 bytes");
  findings_.check(hello.token().find_first_not_of(hello.token().substr(0, 1)) != std::string::npos, "token",
                  "the token is 32 times the same byte: it is to be random");
  findings_.check(
      welcomed_ || hello.enrolment_code() == given_.code, "code",
      "a hello before the first Welcome does not carry the enrolment's code: the robot can not know whether "
      "the server has seen it");
  if (first_hello_.spool_id() == 0) {
    first_hello_ = hello;
  } else {
    findings_.check(hello.token() == first_hello_.token(), "token", "the token is another one on a later connection");
    findings_.check(hello.spool_id() == first_hello_.spool_id(), "spool-id",
                    "spool_id is another one on a later connection of the same session");
    findings_.check(hello.session().session() == first_hello_.session().session(), "session",
                    "the session has another name on a later connection");
    findings_.check(google::protobuf::util::MessageDifferencer::Equals(hello.family(), first_hello_.family()), "family",
                    "the descriptor family is another one on a later connection");
    const auto& runs = hello.spool_runs();
    findings_.check(last_run_ == 0 || std::find(runs.begin(), runs.end(), last_run_) != runs.end(), "spool-runs",
                    "spool_runs lacks the run that was let in before: the server takes it for a copy");
  }
  if (hello.spool_runs_size() > 0) last_run_ = hello.spool_runs(hello.spool_runs_size() - 1);
}

void Judge::keyframe(const v1::Keyframe& message) {
  const std::string name = "keyframe " + std::to_string(message.sequence());
  const auto [before, is_new] = keyframes_.emplace(message.sequence(), message);
  findings_.check(is_new || google::protobuf::util::MessageDifferencer::Equals(before->second, message), "changed",
                  name + " is another one than was sent under its number before");
  if (!is_new) return;
  auto keyframe = from_proto(message);
  if (!keyframe) return findings_.wrong("keyframe-field", "is refused: " + keyframe.error().message);
  if (const auto fits = complete(*keyframe, family_); !fits)
    return findings_.wrong("descriptor-size", fits.error().message);
  if (before != keyframes_.begin())
    findings_.check(std::prev(before)->second.stamp_s() < message.stamp_s(), "stamps",
                    name + ": its stamp is not after the one before");
  const Course::Scan* scan = course_.at(keyframe->stamp_s);
  if (scan == nullptr)
    return findings_.wrong("stamp", name + ": no scan of the session has the stamp " + number(keyframe->stamp_s));
  const Pose T_scan_sent = scan->T_local_sensor.inverse() * keyframe->T_local_sensor;
  findings_.check(T_scan_sent.translation().norm() < 1e-3 && rotation_angle_rad(T_scan_sent) < 1e-3, "pose",
                  name + ": its pose is " + number(T_scan_sent.translation().norm()) + " m and " +
                      number(rotation_angle_rad(T_scan_sent)) + " rad off the scan's (T_local_sensor)");
  findings_.check(std::abs(keyframe->spaciousness_m / scan->spaciousness_m - 1) < 0.02F, "spaciousness",
                  name + ": spaciousness_m is " + number(static_cast<double>(keyframe->spaciousness_m)) + ", not " +
                      number(static_cast<double>(scan->spaciousness_m)));
  const Points points_level = level(scan->T_local_sensor, scan->points_sensor);
  walls(*keyframe, points_level, name);
  descriptor(*keyframe, points_level, name);
}

void Judge::walls(const Keyframe& keyframe, const Points& points_level, const std::string& name) {
  const WallProfile expected = wall_profile(points_level);
  int wrong = 0;
  for (std::size_t i = 0; i < WallProfile::sectors; ++i)
    wrong += std::abs(int{keyframe.walls.code[i]} - int{expected.code[i]}) > 1 ? 1 : 0;
  findings_.check(wrong <= 4, "walls", name + ": " + std::to_string(wrong) + " of 180 wall codes are wrong");
}

void Judge::descriptor(const Keyframe& keyframe, const Points& points_level, const std::string& name) {
  if (!known_ || known_->id() != family_.id) return;  // of a network of the user's own nothing is known here
  const std::string family = family_.id.name;
  const auto expected = known_->extract(points_level);
  const auto& [q, w, place_class] = keyframe.descriptor;
  if (!expected || q.size() != expected->q.size() || w.size() != expected->w.size())
    return findings_.wrong("descriptor-size", name + ": " + family + " has " + std::to_string(known_->q_size()) +
                                                  " + " + std::to_string(known_->w_size()) + " numbers");
  findings_.check(
      farthest(q, expected->q) < 0.05, "q",
      name + ": q is off that of " + family + " by " + number(farthest(q, expected->q)) + " of its largest");
  findings_.check(
      farthest(w, expected->w) < 0.05, "w",
      name + ": w is off that of " + family + " by " + number(farthest(w, expected->w)) + " of its largest");
}

std::uint32_t Judge::points_of(std::uint64_t sequence) const {
  const auto keyframe = keyframes_.find(sequence);
  return keyframe == keyframes_.end() ? 0 : keyframe->second.point_count();
}

void Judge::cloud(std::uint64_t sequence, const std::string& encoded) {
  const std::string name = "cloud of keyframe " + std::to_string(sequence);
  const auto cloud = decode_cloud(encoded);
  if (!cloud) return findings_.wrong("cloud-code", name + ": " + cloud.error().message);
  const bool has_intensity = std::any_of(cloud->sweeps.begin(), cloud->sweeps.end(),
                                         [](const Sweep& sweep) { return !sweep.intensity.empty(); });
  findings_.check(!has_intensity, "cloud-form",
                  name + " has intensities, and this server does not list cloud_form_3: it could not read them");
  findings_.check(point_count(*cloud) == points_of(sequence), "point-count",
                  name + " has " + std::to_string(point_count(*cloud)) + " points, its keyframe says " +
                      std::to_string(points_of(sequence)));
  const auto keyframe = keyframes_.find(sequence);
  const Course::Scan* scan = keyframe == keyframes_.end() ? nullptr : course_.at(keyframe->second.stamp_s());
  if (scan == nullptr) return;
  if (cloud->sweeps.empty()) return findings_.wrong("cloud-sweeps", name + " has no sweep");
  const Sweep& own = cloud->sweeps.back();
  const double near = share_near(own.points, scan->points_sensor, 0.12F);
  findings_.check(own.origin.norm() < 0.02F && near > 0.95, "cloud-frame",
                  name + ": " + number(100 * near) +
                      " % of its last sweep lie on the keyframe's own scan in the sensor frame, its origin is at " +
                      number(static_cast<double>(own.origin.norm())) + " m");
  Points around;  // the scans before it, as they lie in this keyframe's frame
  for (const auto& other : course_.scans()) {
    if (other.stamp_s >= scan->stamp_s || other.stamp_s < scan->stamp_s - 10) continue;
    const Eigen::Isometry3f T = (scan->T_local_sensor.inverse() * other.T_local_sensor).cast<float>();
    for (const auto& p : other.points_sensor) around.emplace_back(T * p);
  }
  for (std::size_t i = 0; i + 1 < cloud->sweeps.size(); ++i)
    findings_.check(
        share_near(cloud->sweeps[i].points, around, 0.15F) > 0.9, "sweep-frame",
        name + ": sweep " + std::to_string(i) + " does not lie where the scans before the keyframe were taken");
}

}  // namespace headframe::conformance
