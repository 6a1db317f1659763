#include "server/merge/cloud_cache.hpp"

#include <utility>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

using Prepared = std::shared_ptr<const PreparedCloud>;

constexpr std::size_t read_at_once = 16;  // encoded clouds held in memory at once until they are prepared

}  // namespace

Prepared CloudCache::get(const KeyframeRef& keyframe, CloudSource& source) { return get({&keyframe, 1}, source)[0]; }

std::vector<Prepared> CloudCache::get(std::span<const KeyframeRef> keyframes, CloudSource& source) {
  std::vector<Prepared> out(keyframes.size());
  for (std::size_t next = 0; next < keyframes.size();) {
    std::vector<std::size_t> missing;
    std::vector<CloudDecoder> read;
    for (; next < keyframes.size() && read.size() < read_at_once; ++next) {
      const KeyframeRef& keyframe = keyframes[next];
      if (const Prepared* known = kept_.find(keyframe)) {
        out[next] = *known;
      } else if (source.state(keyframe) == CloudState::stored) {
        auto decoder = source.load(keyframe);
        if (!decoder) continue;
        missing.push_back(next);
        read.push_back(std::move(*decoder));
      }
    }
    for_blocks(read.size(), 1, threads_, [&](std::size_t i, std::size_t, std::size_t) {
      if (const auto cloud = read[i]())
        out[missing[i]] = std::make_shared<const PreparedCloud>(prepare(*cloud, threads_));
    });
    for (const std::size_t i : missing)
      if (out[i]) keep(keyframes[i], out[i]);
  }
  return out;
}

void CloudCache::keep(const KeyframeRef& keyframe, Prepared cloud) {
  bytes_ += bytes_of(*cloud);
  kept_.put(keyframe, std::move(cloud));
  while (bytes_ > capacity_bytes_ && kept_.size() > 1) bytes_ -= bytes_of(*kept_.drop_oldest());
}

}  // namespace headframe
