#include "server/surroundings/component_maps.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/cloud/cloud_codec.hpp"

namespace headframe {

Result<ComponentMaps::Known> ComponentMaps::refreshed(const SessionSurroundings& around, Time now) {
  std::erase_if(entries_, [&](const Entry& e) { return e.component != around.component.id && now - e.asked > kept; });
  auto entry = std::find_if(entries_.begin(), entries_.end(),
                            [&](const Entry& e) { return e.component == around.component.id; });
  if (entry == entries_.end()) {
    if (entries_.size() >= most_maps)
      return failure(ErrorCode::unavailable, "maps of too many components are asked for; ask again later");
    entry = entries_.emplace(entries_.end());
    entry->component = around.component.id;
    entry->epoch = next_epoch_++;
    if (next_epoch_ == 0) ++next_epoch_;
  }
  entry->asked = now;
  const auto read = [&](SessionId session, std::uint64_t first, const std::function<void(Keyframe)>& visit) {
    return store_.each_keyframe(session, first, visit);
  };
  for (const auto& [session, moves] : around.moves) entry->map.moved(session, moves);
  const bool was_full = entry->map.full();
  const auto done = entry->map.refresh(around.component, around.durable, read, [&] { return stopping_.load(); });
  if (!done)
    spdlog::warn("what robots are told of component {} lacks a session: {}", entry->component, done.error().message);
  if (!was_full && entry->map.full())
    spdlog::warn("component {} is wider than robots can be told of: {} tiles of coverage", entry->component,
                 most_tiles);
  return Known{&entry->map, entry->epoch};
}

Result<ComponentMaps::MapAnswer> ComponentMaps::map_of(const SessionSurroundings& around, const Region& region,
                                                       double resolution_m, const HeldVersion& since, Time now) {
  if (const std::string why = objection(region, resolution_m, limits_); !why.empty())
    return failure(ErrorCode::invalid_argument, why);
  const auto known = refreshed(around, now);
  if (!known) return tl::unexpected(known.error());
  ComponentMap& map = *known->map;
  MapAnswer answer;
  answer.since = since.epoch == known->epoch && since.version >= map.redrawn();
  const Pose T_mine_component = placement_in(around.component, around.receiver)->T_component_session.inverse();
  std::vector<RegionCloud> all;
  for (const Placement& placement : around.component.placements) {
    const auto* keyframes = map.keyframes(placement.session);
    const auto sequences = store_.cloud_sequences(placement.session);
    if (keyframes == nullptr || !sequences) continue;
    map.note_clouds(placement.session, *sequences);
    const Pose T_mine_session = T_mine_component * placement.T_component_session;
    for (const std::uint64_t sequence : *sequences) {
      if (sequence == 0 || sequence > keyframes->size()) continue;
      if (answer.since && map.cloud_version(placement.session, sequence) <= since.version) continue;
      const auto& keyframe = (*keyframes)[sequence - 1];
      all.push_back({{placement.session, sequence}, keyframe.stamp_s, T_mine_session * keyframe.T_local_sensor});
    }
  }
  answer.held = {known->epoch, map.version()};
  const auto near = clouds_near(std::move(all), region, limits_, answer.clouds_left_out);
  const auto read = [&](const KeyframeRef& keyframe) -> Result<KeyframeCloud> {
    const auto encoded = store_.cloud(keyframe);
    if (!encoded) return tl::unexpected(encoded.error());
    return decode_points(*encoded);
  };
  const auto fused = fuse(near, region, resolution_m, limits_, read, [&] { return stopping_.load(); });
  if (!fused) return tl::unexpected(fused.error());
  answer.points = fused->points.size();
  answer.clouds = fused->clouds;
  answer.origin_m = middle_m(region);
  if (fused->points.empty()) return answer;
  // A quarter of a cube, so that rounding loses less than the size of a cube.
  auto encoded = encode_cloud({{{Eigen::Vector3f::Zero(), fused->points}}}, static_cast<float>(resolution_m / 4));
  if (!encoded) return tl::unexpected(encoded.error());
  answer.encoded = std::move(*encoded);
  return answer;
}

}  // namespace headframe
