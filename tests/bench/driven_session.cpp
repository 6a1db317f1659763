#include "tests/bench/driven_session.hpp"

#include <stdexcept>

#include "client/keyframe/keyframe_selector.hpp"
#include "client/keyframe/sweeps.hpp"
#include "common/cloud/cloud_codec.hpp"
#include "common/dataset/session_folder.hpp"
#include "common/descriptor/level.hpp"
#include "common/descriptor/wall_profile.hpp"
#include "common/wire/convert.hpp"

namespace headframe::bench {
namespace {

/// The robot's side of client/robot_client, scan by scan.
class Robot {
 public:
  Robot(Selection selection, const DescriptorFamily& family) : selection_(selection), family_(family) {}
  void add(double stamp_s, const Pose& T_local_sensor, const Points& scan, DrivenSession& out) {
    const Points points = finite_points(scan, 0.3F);
    const auto decision = selector_.add(T_local_sensor, mean_range_m(points));
    if (!decision.keyframe && selection_ == Selection::by_spaciousness) {
      sweeps_.add(T_local_sensor, points);
      return;
    }
    const Points points_level = level(T_local_sensor, points);
    auto descriptor = family_.extract(points_level);
    if (!descriptor) return;
    Keyframe keyframe;
    keyframe.sequence = out.keyframes.size() + 1;
    keyframe.stamp_s = stamp_s;
    keyframe.T_local_sensor = T_local_sensor;
    keyframe.spaciousness_m = decision.spaciousness_m;
    keyframe.descriptor = std::move(*descriptor);
    keyframe.walls = wall_profile(points_level);
    KeyframeCloud cloud = sweeps_.take(T_local_sensor, points);
    cloud = decode_cloud(encode_cloud(cloud).value()).value();
    keyframe.point_count = static_cast<std::uint32_t>(point_count(cloud));
    out.keyframes.push_back(from_proto(to_proto(keyframe).value()).value());
    if (auto ok = complete(out.keyframes.back(), {family_.id(), family_.q_size(), family_.w_size()}); !ok)
      throw std::logic_error(ok.error().message);
    out.clouds.push_back(std::move(cloud));
  }

 private:
  Selection selection_;
  KeyframeSelector selector_;
  SweepCollector sweeps_;
  const DescriptorFamily& family_;
};

DrivenSession keyframes_of(const mine::Recording& recording, Selection selection, double first_stamp_s) {
  const auto family = make_family(default_family_name).value();
  DrivenSession session{.name = recording.robot.name, .world = {}, .family = family->id()};
  session.path = {recording.drive.T_local_sensor, recording.drive.T_world_sensor};
  Robot eyes(selection, *family);
  for (std::size_t i = 0; i < recording.scans.size(); ++i)
    eyes.add(first_stamp_s + recording.robot.style.scan_spacing_m * static_cast<double>(i),
             session.path.T_local_sensor[i], recording.scans[i].points, session);
  return session;
}

}  // namespace

DrivenSession drive_robot(const mine::World& world, const mine::Robot& robot, std::uint64_t seed,
                          const std::string& world_name, double first_stamp_s) {
  DrivenSession session = keyframes_of(mine::record(world, robot, seed), Selection::by_spaciousness, first_stamp_s);
  session.name = world_name + "/" + robot.name;
  session.world = world_name;
  return session;
}

DrivenMine drive_mine(const mine::Request& request, Selection selection) {
  const auto scenario = mine::make_scenario(request);
  if (!scenario) throw std::runtime_error(scenario.error().message);
  const std::string world = std::string(to_string(request.kind)) + "-" + std::to_string(request.seed);
  DrivenMine out;
  std::vector<mine::SeenVoxels> seen;
  for (const mine::Robot& robot : scenario->robots) {
    const mine::Recording recording = mine::record(scenario->world, robot, request.seed);
    DrivenSession session = keyframes_of(recording, selection, 0);
    session.name = world + "/" + robot.name;
    session.world = world;
    out.sessions.push_back(std::move(session));
    seen.push_back(mine::seen(recording, 0.5, 30));
  }
  for (const auto& a : seen) {
    auto& row = out.overlap_pct.emplace_back();
    for (const auto& b : seen) row.push_back(overlap_pct(a, b));
  }
  return out;
}

DrivenSession read_driven_session(const std::filesystem::path& recording, const std::string& robot,
                                  const DescriptorFamily& family) {
  const auto folder = SessionFolder::open(recording / robot);
  if (!folder) throw std::runtime_error(folder.error().message);
  const std::string world = recording.filename();
  DrivenSession session{.name = world + "/" + robot, .world = world, .family = family.id()};
  session.path = test::read_true_path(recording, robot);
  Robot eyes(Selection::by_spaciousness, family);
  for (std::size_t i = 0; i < folder->size(); ++i) {
    const auto scan = folder->load(i);
    if (!scan) throw std::runtime_error(scan.error().message);
    eyes.add(folder->stamp_s(i), folder->T_local_sensor(i), scan->points, session);
  }
  return session;
}

}  // namespace headframe::bench
