// The map around the robot: one question, an answer in parts.
#include <cmath>

#include "client/uplink/surroundings_book.hpp"
#include "common/cloud/cloud_codec.hpp"
#include "common/printable.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_reason_bytes = 1024;

void write(const SphereRegion& region, v1::MapRequest& out) {
  auto& sphere = *out.mutable_sphere();
  sphere.set_x(region.centre_m.x());
  sphere.set_y(region.centre_m.y());
  sphere.set_z(region.centre_m.z());
  sphere.set_radius_m(region.radius_m);
}

void write(const BoxRegion& region, v1::MapRequest& out) {
  auto& box = *out.mutable_box();
  box.set_low_x(region.low_m.x());
  box.set_low_y(region.low_m.y());
  box.set_low_z(region.low_m.z());
  box.set_high_x(region.high_m.x());
  box.set_high_y(region.high_m.y());
  box.set_high_z(region.high_m.z());
}

MapAround about(const v1::MapPart& head) {
  MapAround out;
  out.refused = printable(std::string_view(head.refused()).substr(0, most_reason_bytes));
  out.revision = head.revision();
  out.origin_local_m = {head.origin_x(), head.origin_y(), head.origin_z()};
  out.clouds = head.clouds();
  out.clouds_left_out = head.clouds_left_out();
  out.since = head.since();
  out.held = {head.epoch(), head.version()};
  return out;
}

Result<MapAround> whole_map(const v1::MapPart& head, const std::string& bytes) {
  MapAround out = about(head);
  if (!out.origin_local_m.allFinite()) return failure(ErrorCode::bad_input, "a map whose origin is not finite");
  if (bytes.empty()) return out;
  auto cloud = decode_points(bytes);
  if (!cloud) return failure(ErrorCode::bad_input, "a map that does not decode: " + cloud.error().message);
  for (Sweep& sweep : cloud->sweeps) out.points.insert(out.points.end(), sweep.points.begin(), sweep.points.end());
  return out;
}

}  // namespace

void SurroundingsBook::want_map(const MapQuestion& question) { map_ = Asked{question, ++maps_, std::nullopt, {}}; }

v1::RobotMessage SurroundingsBook::map_question() const {
  v1::RobotMessage message;
  auto& request = *message.mutable_map_request();
  request.set_id(map_->id);
  std::visit([&](const auto& region) { write(region, request); }, map_->question.region);
  request.set_resolution_m(static_cast<float>(map_->question.resolution_m));
  request.set_epoch(map_->question.since.epoch);
  request.set_version(map_->question.since.version);
  return message;
}

/// A part of another map, or one that does not follow, is dropped: it was requested before a connection broke.
Result<SurroundingsBook::Taken> SurroundingsBook::take(const v1::MapPart& message) {
  Taken taken;
  if (!map_ || message.id() != map_->id || message.offset() != map_->bytes.size()) return taken;
  if (message.offset() == 0) map_->head = message;
  if (!map_->head) return taken;
  if (map_->head->total_bytes() > limits::cloud_bytes) return failure(ErrorCode::bad_input, "a map that is too large");
  map_->head->clear_data();
  map_->bytes += message.data();
  if (map_->bytes.size() > map_->head->total_bytes())
    return failure(ErrorCode::bad_input, "a map of more bytes than were announced");
  if (map_->bytes.size() < map_->head->total_bytes()) {
    if (message.data().empty()) return failure(ErrorCode::bad_input, "a part of a map without any of it");
    taken.next.emplace();
    taken.next->mutable_map_next()->set_id(map_->id);
    taken.next->mutable_map_next()->set_offset(static_cast<std::uint32_t>(map_->bytes.size()));
    return taken;
  }
  auto map = whole_map(*map_->head, map_->bytes);
  map_.reset();
  if (!map) return tl::unexpected(map.error());
  taken.told = std::move(*map);
  return taken;
}

}  // namespace headframe
