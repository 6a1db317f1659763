// Pages with what is newer than a version.
#include <algorithm>

#include "server/surroundings/component_map.hpp"

namespace headframe {
namespace {

constexpr std::size_t point_bytes = 6, piece_bytes = 24, name_bytes = 56, tile_bytes = 12;  // about, as sent

}  // namespace

/// A session's number is sent when it appears, its placement whenever that changes.
void ComponentMap::add_placed(std::uint64_t version, std::vector<Item>& items) const {
  for (const auto& [id, path] : paths_)
    if (!path.gone && path.placed > version) items.push_back({path.placed, Item::Kind::placed, id});
}

std::optional<ComponentMap::Piece> ComponentMap::paths_after(std::uint64_t version, SessionId receiver,
                                                             std::size_t page_bytes) const {
  std::vector<Item> items;
  add_placed(version, items);
  for (const auto& [id, path] : paths_) {
    if (id == receiver) continue;
    if (path.gone && path.left > version) items.push_back({path.left, Item::Kind::gone, id});
    const auto newer = std::partition_point(path.points.begin(), path.points.end(),
                                            [&](const Point& p) { return p.version <= version; });
    for (auto p = newer; p != path.points.end(); ++p)
      items.push_back({p->version, Item::Kind::point, id, static_cast<std::size_t>(p - path.points.begin())});
  }
  return piece_of(std::move(items), page_bytes);
}

std::optional<ComponentMap::Piece> ComponentMap::coverage_after(std::uint64_t version, std::size_t page_bytes) const {
  std::vector<Item> items;
  add_placed(version, items);
  for (const auto& [index, tile] : told_)
    if (tile.version > version) items.push_back({tile.version, Item::Kind::tile, 0, 0, &index});
  return piece_of(std::move(items), page_bytes);
}

/// The oldest items first, until the page is full.
std::optional<ComponentMap::Piece> ComponentMap::piece_of(std::vector<Item> items, std::size_t page_bytes) const {
  if (items.empty()) return std::nullopt;
  std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.version < b.version; });
  Piece piece;
  std::size_t bytes = 0;
  for (const Item& item : items) {
    piece.more = bytes >= page_bytes;
    if (piece.more) break;
    bytes += add(item, piece);
    piece.version = item.version;
  }
  return piece;
}

/// Approximate size on the wire in bytes.
std::size_t ComponentMap::add(const Item& item, Piece& piece) const {
  if (item.kind == Item::Kind::placed) {
    piece.placed.push_back(item.session);
    return name_bytes;
  }
  if (item.kind == Item::Kind::tile) {
    piece.tiles.emplace_back(*item.tile, told_.at(*item.tile).encoded);
    return tile_bytes + piece.tiles.back().second.size();
  }
  const Path& path = paths_.at(item.session);
  if (item.kind == Item::Kind::gone) {
    piece.paths.push_back({item.session, 0, {}, {}, true});
    return piece_bytes;
  }
  const bool follows = !piece.paths.empty() && piece.paths.back().session == item.session && !piece.paths.back().gone;
  if (!follows) piece.paths.push_back({item.session, item.point, {}, {}, false});
  if (!follows && item.point > 0) piece.paths.back().last = path.points[item.point - 1].at;
  piece.paths.back().points.push_back(path.points[item.point].at);
  return follows ? point_bytes : piece_bytes + point_bytes;
}

}  // namespace headframe
