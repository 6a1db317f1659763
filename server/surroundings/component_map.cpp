#include "server/surroundings/component_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace headframe {
namespace {

PathPoint path_point(const Eigen::Vector3d& p_m) {
  constexpr double most = 2e9;
  PathPoint at{};
  for (int axis = 0; axis < 3; ++axis)
    at[static_cast<std::size_t>(axis)] =
        static_cast<std::int32_t>(std::lround(std::clamp(p_m[axis] / path_unit_m, -most, most)));
  return at;
}

double distance_m(const PathPoint& a, const PathPoint& b) {
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) squared += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
  return std::sqrt(squared) * path_unit_m;
}

}  // namespace

bool ComponentMap::moved_away(const Path& path, const Pose& T_component_session) {
  const Eigen::Vector3d shift = T_component_session.translation() - path.T_component_session.translation();
  const Eigen::Matrix3d turn = T_component_session.linear() - path.T_component_session.linear();
  if (shift.isZero(0) && turn.isZero(0)) return false;
  if (path.keyframes.empty()) return shift.norm() > moved_m;
  return std::any_of(path.keyframes.begin(), path.keyframes.end(), [&](const PlacedKeyframe& k) {
    return (shift + turn * k.T_local_sensor.translation()).norm() > moved_m;
  });
}

/// Adds a point if the path has grown by point_every_m since the last one.
void ComponentMap::add_point(Path& path, const PlacedKeyframe& keyframe) {
  const PathPoint at = path_point(path.T_component_session * keyframe.T_local_sensor.translation());
  if (path.points.empty() || distance_m(path.points.back().at, at) >= point_every_m)
    path.points.push_back({at, ++version_});
}

/// Places the session: all of its points and clouds count as new.
void ComponentMap::place(Path& path, const Pose& T_component_session) {
  path.T_component_session = T_component_session;
  path.gone = false;
  path.placed = ++version_;
  path.points.clear();
  for (const PlacedKeyframe& keyframe : path.keyframes) add_point(path, keyframe);
  for (auto& [sequence, version] : path.clouds) version = version_;
}

/// A session that was split now ends where its odometry jumped.
bool ComponentMap::shortened(Path& path, std::uint64_t keyframes) {
  if (path.keyframes.size() <= keyframes) return false;
  path.keyframes.resize(keyframes);
  path.clouds.erase(path.clouds.upper_bound(keyframes), path.clouds.end());
  return true;
}

void ComponentMap::moved(SessionId session, std::uint64_t moves) {
  const auto known = paths_.find(session);
  if (known == paths_.end() || known->second.moves == moves) return;
  Path& path = known->second;
  path.moves = moves;
  path.stale = true;
  path.keyframes.clear();
}

/// Applies new placements. Returns true if what was drawn is no longer valid.
bool ComponentMap::settle(const Component& component, const std::map<SessionId, std::uint64_t>& durable) {
  bool changed = false;
  for (auto& [id, path] : paths_) {
    if (path.gone || placement_in(component, id) != nullptr) continue;
    path.gone = changed = true;
    path.left = ++version_;
    path.points.clear();
  }
  for (const Placement& placement : component.placements) {
    const auto [known, fresh] = paths_.try_emplace(placement.session);
    const auto there = durable.find(placement.session);
    const bool is_shorter = there != durable.end() && shortened(known->second, there->second);
    const bool is_stale = std::exchange(known->second.stale, false);
    if (!fresh && !known->second.gone && !is_shorter && !is_stale &&
        !moved_away(known->second, placement.T_component_session))
      continue;
    changed = changed || is_stale || !known->second.keyframes.empty();
    place(known->second, placement.T_component_session);
  }
  return changed;
}

void ComponentMap::draw(SessionId id, const Path& path, const Keyframe& keyframe) {
  const auto number = static_cast<std::uint32_t>(id);
  const Pose T_component_sensor = path.T_component_session * keyframe.T_local_sensor;
  grid_.see(number, T_component_sensor, keyframe.stamp_s, keyframe.walls);
  const bool follows = keyframe.sequence > 1 && keyframe.sequence - 2 < path.keyframes.size();
  const Eigen::Vector3d before =
      follows ? path.T_component_session * path.keyframes[keyframe.sequence - 2].T_local_sensor.translation()
              : Eigen::Vector3d(T_component_sensor.translation());
  const bool walked = (before - T_component_sensor.translation()).norm() <= longest_step_m;
  grid_.walk(number, walked ? before : T_component_sensor.translation(), T_component_sensor.translation(),
             keyframe.stamp_s);
}

Result<void> ComponentMap::refresh(const Component& component, const std::map<SessionId, std::uint64_t>& durable,
                                   const ReadKeyframes& read, const std::function<bool()>& stop) {
  const bool anew = settle(component, durable);
  if (anew) {
    grid_ = CoverageGrid(most_tiles_);
    redrawn_ = version_;
  }
  Result<void> done;
  for (const Placement& placement : component.placements) {
    Path& path = paths_.at(placement.session);
    const std::uint64_t known = path.keyframes.size();
    const auto there = durable.find(placement.session);
    if (stop() || (!anew && (there == durable.end() || there->second <= known))) continue;
    const auto one = read(placement.session, anew ? 1 : known + 1, [&](const Keyframe& keyframe) {
      if (stop()) return;
      if (keyframe.sequence == path.keyframes.size() + 1) {
        path.keyframes.push_back({keyframe.sequence, keyframe.stamp_s, keyframe.T_local_sensor});
        add_point(path, path.keyframes.back());
      }
      draw(placement.session, path, keyframe);
    });
    if (!one && done) done = one;
  }
  number_tiles();
  return done;
}

/// Tiles whose content differs from what was reported get a new version; a tile that nothing is seen in any longer
/// stays, empty.
void ComponentMap::number_tiles() {
  for (const TileIndex& index : grid_.take_changed()) {
    std::string encoded = encode_tile(grid_.tiles().at(index));
    Tile& told = told_[index];
    if (told.encoded == encoded) continue;
    told = {++version_, std::move(encoded)};
  }
  for (auto& [index, told] : told_)
    if (!told.encoded.empty() && !grid_.tiles().contains(index)) told = {++version_, ""};
}

const std::vector<ComponentMap::PlacedKeyframe>* ComponentMap::keyframes(SessionId session) const {
  const auto known = paths_.find(session);
  return known == paths_.end() || known->second.gone ? nullptr : &known->second.keyframes;
}

double ComponentMap::last_stamp_s(SessionId session) const {
  const auto known = paths_.find(session);
  return known == paths_.end() || known->second.keyframes.empty() ? 0 : known->second.keyframes.back().stamp_s;
}

void ComponentMap::note_clouds(SessionId session, const std::vector<std::uint64_t>& sequences) {
  const auto known = paths_.find(session);
  if (known == paths_.end()) return;
  for (const std::uint64_t sequence : sequences)
    if (known->second.clouds.try_emplace(sequence, version_ + 1).second) ++version_;
}

std::uint64_t ComponentMap::cloud_version(SessionId session, std::uint64_t sequence) const {
  const auto known = paths_.find(session);
  if (known == paths_.end()) return 0;
  const auto cloud = known->second.clouds.find(sequence);
  return cloud == known->second.clouds.end() ? 0 : cloud->second;
}

}  // namespace headframe
