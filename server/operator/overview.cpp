#include "server/operator/overview.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "server/operator/trajectory_export.hpp"

namespace headframe {
namespace {

static_assert(std::endian::native == std::endian::little, "lengths are written as they lie in memory");

void append_part(std::string& out, const std::string& part) {
  const auto bytes = static_cast<std::uint32_t>(part.size());
  std::array<char, sizeof bytes> head{};
  std::memcpy(head.data(), &bytes, sizeof bytes);
  out.append(head.data(), head.size()).append(part);
}

/// Appends all remaining pieces of the body.
Result<void> drain(BodySource& body, std::string& out) {
  for (;;) {
    auto piece = body.next();
    if (!piece) return tl::unexpected(piece.error());
    if (!*piece) return {};
    out += **piece;
  }
}

}  // namespace

Result<std::optional<std::string>> Overview::next() {
  if (!look_) {
    look_ = look_at(station_);
    choose_sessions();
    std::string out;
    append_part(out, snapshot_event(*look_));
    return out;
  }
  if (at_ == look_->sessions.size()) return std::nullopt;
  return session(look_->sessions[at_++].id).map([](std::string parts) { return std::optional(std::move(parts)); });
}

void Overview::choose_sessions() {
  std::vector<const SessionRow*> rows;
  for (const SessionRow& row : look_->sessions) rows.push_back(&row);
  std::sort(rows.begin(), rows.end(), [](const SessionRow* s, const SessionRow* t) {
    return std::pair(s->connected, s->id) > std::pair(t->connected, t->id);
  });
  std::size_t left = most_clouds_;
  for (const SessionRow* row : rows) {
    const std::size_t clouds = tiles_.has(row->id, level_) ? 0 : row->clouds;
    if (clouds > left) continue;
    left -= clouds;
    with_points_.insert(row->id);
  }
}

Result<std::string> Overview::session(SessionId id) const {
  std::string out, path, points;
  PathJson path_body(station_, id, 1, path_tolerance_m_);
  if (auto read = drain(path_body, path); !read) return tl::unexpected(read.error());
  if (with_points_.contains(id)) {
    const auto row =
        std::find_if(look_->sessions.begin(), look_->sessions.end(), [&](const SessionRow& s) { return s.id == id; });
    PointStream points_body(tiles_.tile(id, level_, row->keyframes, row->moves), 0, most_points_);
    if (auto read = drain(points_body, points); !read) return tl::unexpected(read.error());
  }
  append_part(out, path);
  append_part(out, points);
  return out;
}

}  // namespace headframe
