#include "server/operator/point_tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace headframe {
namespace {

static_assert(std::endian::native == std::endian::little, "blocks are written as they lie in memory");

constexpr double unit_m = 0.005;
constexpr std::size_t block_head_bytes = 20, point_bytes = 6;
constexpr std::size_t filled_bytes = 40;  // approximate memory per filled cube

template <class T>
void append(std::string& out, T value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

/// 21 bits per axis: 200 km at the finest level; farther apart, cubes share a key.
std::uint64_t cube_key(const Eigen::Vector3d& p_m, double cube_m) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis)
    key =
        key << 21 | (static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(p_m[axis] / cube_m))) & 0x1fffff);
  return key;
}

}  // namespace

Result<std::optional<std::string>> PointTile::block(std::size_t index) {
  const std::lock_guard lock(mutex_);
  while (blocks_.size() <= index) {
    const auto made = make_block();
    if (!made) return tl::unexpected(made.error());
    if (!*made) return std::nullopt;
  }
  return blocks_[index];
}

/// Makes a block of the next cloud that has none; false: no such cloud is stored. Call with the lock held.
Result<bool> PointTile::make_block() {
  if (keyframes_.empty()) {
    auto read = station_.trajectory(session_);
    if (!read) return tl::unexpected(read.error());
    keyframes_ = std::move(*read);
    for (Keyframe& keyframe : keyframes_) keyframe.descriptor = {};  // to save memory: they may stay for long
    at_ = 0;
  }
  while (at_ < keyframes_.size()) {
    const Keyframe& keyframe = keyframes_[at_++];
    if (done_.contains(keyframe.sequence)) continue;
    const auto cloud = station_.cloud(session_, keyframe.sequence);
    if (!cloud && cloud.error().code == ErrorCode::not_found) continue;  // it may still arrive
    if (!cloud) return tl::unexpected(cloud.error());
    done_.insert(keyframe.sequence);
    newest_ = std::max(newest_.load(), keyframe.sequence);
    const std::size_t filled_before = filled_.size();
    blocks_.push_back(encoded(keyframe, *cloud));
    bytes_ += blocks_.back().size() + (filled_.size() - filled_before) * filled_bytes;
    return true;
  }
  keyframes_ = {};
  return false;
}

std::string PointTile::encoded(const Keyframe& keyframe, const KeyframeCloud& cloud) {
  const Eigen::Vector3d origin_m = keyframe.T_local_sensor.translation();
  std::string points;
  for (const Sweep& sweep : cloud.sweeps)
    for (const Eigen::Vector3f& p_sensor : sweep.points) {
      if (!p_sensor.allFinite()) continue;
      const Eigen::Vector3d p_m = keyframe.T_local_sensor * p_sensor.cast<double>(), offset = (p_m - origin_m) / unit_m;
      if (offset.cwiseAbs().maxCoeff() > 32767 || !filled_.insert(cube_key(p_m, cube_m_)).second) continue;
      for (int axis = 0; axis < 3; ++axis) append(points, static_cast<std::int16_t>(std::lround(offset[axis])));
    }
  std::string out;
  out.reserve(block_head_bytes + points.size());
  append(out, static_cast<std::uint32_t>(keyframe.sequence));
  append(out, static_cast<std::uint32_t>(points.size() / point_bytes));
  for (int axis = 0; axis < 3; ++axis) append(out, static_cast<float>(origin_m[axis]));
  return out + points;
}

std::shared_ptr<PointTile> PointTiles::tile(SessionId session, std::size_t level, std::uint64_t keyframes,
                                            std::uint64_t moves) {
  const std::lock_guard lock(mutex_);
  const std::pair key(session, level);
  const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
  if (known != entries_.end())
    entries_.splice(entries_.begin(), entries_, known);
  else
    entries_.push_front({key, std::make_shared<PointTile>(station_, session, level, moves)});
  auto& tile = entries_.front().tile;
  if (tile->newest() > keyframes || tile->moves() != moves)
    tile = std::make_shared<PointTile>(station_, session, level, moves);
  std::size_t bytes = 0;
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    bytes += entry->tile->bytes();
    entry = bytes > most_bytes_ && entry != entries_.begin() ? entries_.erase(entry) : std::next(entry);
  }
  return entries_.front().tile;
}

bool PointTiles::has(SessionId session, std::size_t level) {
  const std::lock_guard lock(mutex_);
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const Entry& e) { return e.key == std::pair(session, level) && e.tile->bytes() > 0; });
}

Result<std::optional<std::string>> PointStream::next() {
  if (left_ == 0) return std::nullopt;
  auto block = tile_->block(next_++);
  if (block && *block) left_ -= std::min(left_, ((*block)->size() - block_head_bytes) / point_bytes);
  return block;
}

}  // namespace headframe
