#include "server/net/surroundings_pages.hpp"

#include <algorithm>
#include <set>

#include "common/wire/convert.hpp"

namespace headframe {
namespace {

constexpr double least_time_of_day_s =
    1e9;  // a stamp beyond counts from the epoch: a clock that was never set counts from 0

v1::SurroundingsPage page_of(const SessionSurroundings& around, const HeldVersion& held, std::uint64_t epoch,
                             const ComponentMap::Piece& piece) {
  v1::SurroundingsPage page;
  page.set_epoch(epoch);
  page.set_version(piece.version);
  page.set_anew(held.epoch != epoch);
  page.set_more(piece.more);
  page.set_revision(around.revision);
  page.set_component(static_cast<std::uint64_t>(around.component.id));
  if (const auto anchor = around.keys.find(around.component.id); anchor != around.keys.end())
    *page.mutable_anchor() = to_proto(anchor->second);
  if (const Placement* own = placement_in(around.component, around.receiver))
    *page.mutable_t_component_session() = to_proto(own->T_component_session);
  return page;
}

/// With its names if it is new to the robot.
void number(const SessionSurroundings& around, SessionId session, bool named, const ComponentMap& map, double now_s,
            google::protobuf::RepeatedPtrField<v1::NumberedSession>& out) {
  auto& entry = *out.Add();
  entry.set_number(static_cast<std::uint64_t>(session));
  const auto key = around.keys.find(session);
  if (named && key != around.keys.end()) *entry.mutable_session() = to_proto(key->second);
  const double stamp_s = map.last_stamp_s(session);
  entry.set_last_stamp_s(stamp_s);
  entry.set_age_s(stamp_s > least_time_of_day_s ? std::max(0.0, now_s - stamp_s) : -1);
}

}  // namespace

v1::SurroundingsPage nothing_to_tell(const HeldVersion& held, const std::string& why) {
  v1::SurroundingsPage page;
  page.set_epoch(held.epoch);
  page.set_version(held.version);
  page.set_anew(true);
  page.set_missing(why);
  return page;
}

v1::Trajectories trajectories_page(const SessionSurroundings& around, const HeldVersion& held,
                                   const ComponentMaps::Known& known, const ComponentMap::Piece& piece, double now_s) {
  v1::Trajectories out;
  *out.mutable_page() = page_of(around, held, known.epoch, piece);
  std::set<SessionId> named(piece.placed.begin(), piece.placed.end());
  for (const SessionId session : named) number(around, session, true, *known.map, now_s, *out.mutable_sessions());
  for (const ComponentMap::PathPiece& path : piece.paths) {
    if (!path.gone && named.insert(path.session).second)
      number(around, path.session, false, *known.map, now_s, *out.mutable_sessions());
    auto& part = *out.add_parts();
    part.set_session(static_cast<std::uint64_t>(path.session));
    part.set_first(static_cast<std::uint32_t>(path.first));
    part.set_gone(path.gone);
    PathPoint before = path.last.value_or(PathPoint{});
    for (const PathPoint& point : path.points) {
      for (std::size_t i = 0; i < 3; ++i) part.add_steps(point[i] - before[i]);
      before = point;
    }
  }
  return out;
}

v1::Coverage coverage_page(const SessionSurroundings& around, const HeldVersion& held,
                           const ComponentMaps::Known& known, const ComponentMap::Piece& piece, double now_s) {
  v1::Coverage out;
  *out.mutable_page() = page_of(around, held, known.epoch, piece);
  for (const SessionId session : piece.placed)
    number(around, session, true, *known.map, now_s, *out.mutable_sessions());
  out.set_cell_m(static_cast<float>(coverage_cell_m));
  out.set_tile_cells(static_cast<std::uint32_t>(coverage_tile_cells));
  for (const auto& [index, encoded] : piece.tiles) {
    auto& tile = *out.add_tiles();
    tile.set_x(index.x);
    tile.set_y(index.y);
    tile.set_cells(encoded);
  }
  return out;
}

v1::MapPart map_head(std::uint64_t id, std::uint64_t revision, const ComponentMaps::MapAnswer& answer) {
  v1::MapPart part;
  part.set_id(id);
  part.set_total_bytes(static_cast<std::uint32_t>(answer.encoded.size()));
  part.set_origin_x(answer.origin_m.x());
  part.set_origin_y(answer.origin_m.y());
  part.set_origin_z(answer.origin_m.z());
  part.set_points(static_cast<std::uint32_t>(answer.points));
  part.set_clouds(static_cast<std::uint32_t>(answer.clouds));
  part.set_clouds_left_out(static_cast<std::uint32_t>(answer.clouds_left_out));
  part.set_since(answer.since);
  part.set_revision(revision);
  part.set_epoch(answer.held.epoch);
  part.set_version(answer.held.version);
  return part;
}

}  // namespace headframe
