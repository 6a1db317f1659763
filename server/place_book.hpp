#pragma once

#include <map>

#include "server/prepared_clouds.hpp"
#include "server/registration/place.hpp"

namespace headframe {

/// A session's path, and the keyframe whose surroundings are wanted.
struct PlaceRequest {
  SessionId session = 0;
  std::span<const Keyframe> keyframes;
  std::span<const double> path_to_m;  // length of the path to each keyframe
  std::size_t keyframe = 0;
};

/// The places of sessions, one for every 3 m of path, made when first asked for, made anew when more of their clouds
/// have come, and kept while they fit, with the images of the sweeps that they look from: the least recently used go
/// first. Not thread safe.
class PlaceBook {
 public:
  PlaceBook(std::size_t capacity_bytes, int threads, const PlaceConfig& config, PreparedClouds& prepared)
      : capacity_bytes_(capacity_bytes), threads_(threads), config_(config), prepared_(prepared) {}

  /// The place nearest to each, in order. What a place can not know, because clouds are missing, it leaves empty.
  std::vector<PlacePtr> get(std::span<const PlaceRequest> requests, CloudSource& source);

 private:
  struct Key {
    SessionId session = 0;
    std::size_t keyframe = 0;
    auto operator<=>(const Key&) const = default;
  };
  struct Entry {
    PlacePtr place;
    std::size_t clouds = 0;
  };
  void keep(const Key& key, PlacePtr place, std::size_t clouds);
  void let_go(const Place& place);

  std::size_t capacity_bytes_;
  int threads_;
  PlaceConfig config_;
  PreparedClouds& prepared_;
  std::size_t bytes_ = 0;
  Recent<Key, Entry> kept_;
  std::map<const SightImage*, std::size_t> looked_from_;  // by so many of the places
};

}  // namespace headframe
