#pragma once
// Where could two sessions lie on each other? One list from several sources, best first, for the registration to judge.

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/descriptor/family.hpp"
#include "server/place/descriptor_index.hpp"
#include "server/place/session_walls.hpp"
#include "server/place/wall_search.hpp"

namespace headframe {

struct Hypothesis {
  Pose T_a_b = Pose::Identity();  // 4 degrees of freedom: both frames have z along gravity
  double score = 0;               // of a piece of b's walls laid on a's: comparable whatever the source
  std::size_t centre_b = 0;       // index of the keyframe of b in the middle of that piece
};

/// A neighbour of a keyframe of b among the keyframes of a, by index, from the descriptor index.
struct MatchedPair {
  std::size_t a = 0;
  std::size_t b = 0;
  float squared_distance = 0;
};

/// Finds hypotheses for pairs of sessions, and remembers what it drew and found: a pair is searched again when one of
/// both has grown by news_m. Not thread safe.
class HypothesisFinder {
 public:
  struct Config {
    std::size_t most = 8;      // handed on
    std::size_t refined = 60;  // coarse placements looked at more closely ...
    std::size_t fine = 16;     // ... and of these, to half a cell
    double news_m = 15;
    int threads = 1;
  };
  explicit HypothesisFinder(const Config& config) : config_(config) {}

  std::vector<Hypothesis> find(SessionId id_a, std::span<const Keyframe> a, SessionId id_b, std::span<const Keyframe> b,
                               std::span<const MatchedPair> matches, const DescriptorFamily* family);

 private:
  struct Found {
    double path_a_m = 0, path_b_m = 0;
    std::vector<Hypothesis> hypotheses;
  };
  const SessionWalls& walls(SessionId id, std::span<const Keyframe> keyframes);

  Config config_;
  std::map<SessionId, std::unique_ptr<SessionWalls>> walls_;
  std::map<std::pair<SessionId, SessionId>, Found> found_;
};

/// FRAME's T_0, for each of the best yaw differences: the levelled frames of the two keyframes on each other. Empty
/// without w.
std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, const DescriptorFamily& family,
                                     std::size_t most_yaws);

}  // namespace headframe
