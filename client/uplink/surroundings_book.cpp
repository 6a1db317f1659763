#include "client/uplink/surroundings_book.hpp"

#include <cmath>
#include <limits>

#include "common/printable.hpp"
#include "common/wire/convert.hpp"

namespace headframe {
namespace {

constexpr double path_unit_m = 0.1;
constexpr std::size_t most_words = 1024;  // of a text

std::string words(const std::string& text) { return printable(std::string_view(text).substr(0, most_words)); }

Result<void> read(const v1::SurroundingsPage& page, SurroundingsTold& out) {
  out.revision = page.revision();
  out.component = page.component();
  out.missing = words(page.missing());
  out.state = out.missing.empty() ? SurroundingsTold::State::told : SurroundingsTold::State::none;
  out.anchor = {};
  out.T_component_local.setIdentity();
  if (!out.missing.empty()) return {};
  const auto anchor = from_proto(page.anchor());
  const auto T = from_proto(page.t_component_session());
  if (!anchor) return tl::unexpected(anchor.error());
  if (!T) return tl::unexpected(T.error());
  out.anchor = *anchor;
  out.T_component_local = *T;
  return {};
}

Result<void> read(const v1::NumberedSession& from, SessionKey& session) {
  if (!from.has_session()) return {};
  const auto key = from_proto(from.session());
  if (!key) return tl::unexpected(key.error());
  session = *key;
  return {};
}

v1::SurroundingsRequest request(const HeldVersion& held, bool stop) {
  v1::SurroundingsRequest out;
  out.set_epoch(held.epoch);
  out.set_version(held.version);
  out.set_stop(stop);
  return out;
}

tl::unexpected<Error> bad(const std::string& what) { return failure(ErrorCode::bad_input, what); }

}  // namespace

v1::RobotMessage SurroundingsBook::trajectories_question() const {
  v1::RobotMessage message;
  *message.mutable_trajectories_request() = request(trajectories_held_, !wants_trajectories_);
  return message;
}

v1::RobotMessage SurroundingsBook::coverage_question() const {
  v1::RobotMessage message;
  *message.mutable_coverage_request() = request(coverage_held_, !wants_coverage_);
  return message;
}

std::vector<v1::RobotMessage> SurroundingsBook::questions() {
  std::vector<v1::RobotMessage> all;
  if (wants_trajectories_) all.push_back(trajectories_question());
  if (wants_coverage_) all.push_back(coverage_question());
  if (map_) {
    map_->head.reset();  // a partial answer starts again
    map_->bytes.clear();
    all.push_back(map_question());
  }
  return all;
}

Result<SurroundingsBook::Taken> SurroundingsBook::take(const v1::ServerMessage& message) {
  auto taken = message.has_trajectories() ? take(message.trajectories())
               : message.has_coverage()   ? take(message.coverage())
               : message.has_map_part()   ? take(message.map_part())
                                          : Result<Taken>(Taken{});
  if (!taken) trajectories_held_ = coverage_held_ = {};  // a partial answer is sent again as a whole
  return taken;
}

Result<SurroundingsBook::Taken> SurroundingsBook::take(const v1::Trajectories& message) {
  if (!wants_trajectories_) return Taken{};
  if (auto ok = read(message.page(), trajectories_); !ok) return bad("trajectories: " + ok.error().message);
  if (message.page().anew()) {
    paths_.clear();
    points_ = 0;
  }
  for (const v1::NumberedSession& from : message.sessions()) {
    if (paths_.size() >= most_sessions) return bad("trajectories of too many sessions");
    Path& path = paths_[from.number()];
    if (auto ok = read(from, path.session); !ok) return bad("trajectories: " + ok.error().message);
    if (!std::isfinite(from.last_stamp_s()) || !std::isfinite(from.age_s())) return bad("a time that is not finite");
    path.last_stamp_s = from.last_stamp_s();
    path.age_s = from.age_s() >= 0 ? std::optional(from.age_s()) : std::nullopt;
  }
  bool follows = true;
  for (const v1::PathPart& part : message.parts()) {
    const auto added = add_path(part);
    if (!added) return tl::unexpected(added.error());
    follows = follows && *added;
  }
  trajectories_held_ = follows ? HeldVersion{message.page().epoch(), message.page().version()} : HeldVersion{};
  Taken taken;
  taken.next = trajectories_question();
  if (follows && !message.page().more()) taken.told = whole_trajectories();
  return taken;
}

/// Returns false if it does not continue the copy.
Result<bool> SurroundingsBook::add_path(const v1::PathPart& part) {
  const auto known = paths_.find(part.session());
  if (known == paths_.end()) return false;
  Path& path = known->second;
  if (part.gone() || part.first() == 0) {
    points_ -= path.points.size();
    path.points.clear();
  }
  path.in = !part.gone();
  if (part.gone()) return true;
  if (part.first() != path.points.size()) return false;
  if (part.steps_size() % 3 != 0) return bad("a path whose points are not of three numbers");
  points_ += static_cast<std::size_t>(part.steps_size() / 3);
  if (points_ > most_points_) return bad("trajectories of too many points");
  for (int i = 0; i < part.steps_size(); i += 3) {
    std::array<std::int32_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      const std::int64_t sum = std::int64_t{path.points.empty() ? 0 : path.points.back()[k]} + part.steps(i + axis);
      if (sum < std::numeric_limits<std::int32_t>::min() || sum > std::numeric_limits<std::int32_t>::max())
        return bad("a path that goes too far");
      at[k] = static_cast<std::int32_t>(sum);
    }
    path.points.push_back(at);
  }
  return true;
}

Trajectories SurroundingsBook::whole_trajectories() const {
  Trajectories whole = trajectories_;
  const Pose T_local_component = whole.T_component_local.inverse();
  for (const auto& [number, path] : paths_) {
    if (!path.in) continue;
    auto& out = whole.paths.emplace_back(Trajectories::Path{path.session, path.last_stamp_s, path.age_s, {}});
    for (const auto& p : path.points)
      out.p_local_m.push_back(T_local_component * (path_unit_m * Eigen::Vector3d(p[0], p[1], p[2])));
  }
  return whole;
}

Result<SurroundingsBook::Taken> SurroundingsBook::take(const v1::Coverage& message) {
  if (!wants_coverage_) return Taken{};
  if (auto ok = read(message.page(), coverage_); !ok) return bad("coverage: " + ok.error().message);
  if (message.page().anew()) {
    coverage_.tiles.clear();
    coverage_.sessions.clear();
  }
  if (message.tiles_size() > 0 && (message.cell_m() != coverage_cell_m || message.tile_cells() != coverage_tile_cells))
    return bad("coverage in cells of another size");
  for (const v1::NumberedSession& from : message.sessions()) {
    if (coverage_.sessions.size() >= most_sessions) return bad("coverage of too many sessions");
    if (auto ok = read(from, coverage_.sessions[from.number()]); !ok) return bad("coverage: " + ok.error().message);
  }
  for (const v1::CoverageTile& from : message.tiles()) {
    auto tile = decode_tile(from.cells());
    if (!tile) return tl::unexpected(tile.error());
    if (from.cells().empty()) {
      coverage_.tiles.erase({from.x(), from.y()});
      continue;
    }
    coverage_.tiles[{from.x(), from.y()}] = std::make_shared<const CoverageTile>(std::move(*tile));
    if (coverage_.tiles.size() > most_tiles) return bad("coverage of too many tiles");
  }
  coverage_held_ = {message.page().epoch(), message.page().version()};
  Taken taken;
  taken.next = coverage_question();
  if (!message.page().more()) taken.told = coverage_;
  return taken;
}

}  // namespace headframe
