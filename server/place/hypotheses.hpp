#pragma once
// Where could two sessions lie on each other? One list from several sources, best first, for the registration to judge.

#include <map>
#include <span>
#include <vector>

#include "common/descriptor/family.hpp"
#include "server/place/descriptor_index.hpp"
#include "server/place/wall_correlation.hpp"

namespace headframe {

struct Hypothesis {
  Pose T_a_b = Pose::Identity();  // 4 degrees of freedom: both frames have z along gravity
  double score = 0;               // of the wall maps laid on each other: comparable whatever the source
};

/// A stretch of a session's path, by keyframe index: [begin, end).
struct Piece {
  std::size_t begin = 0;
  std::size_t end = 0;
  auto operator<=>(const Piece&) const = default;
};

/// Pieces of piece_m of path, each half over the one before: short enough that drift does not bend them, long enough to
/// be told apart. A level above another is in another piece, mostly.
std::vector<Piece> cut_pieces(std::span<const Keyframe> keyframes, double piece_m);

/// A neighbour of a keyframe of b among the keyframes of a, by index, from the descriptor index.
struct MatchedPair {
  std::size_t a = 0;
  std::size_t b = 0;
  float squared_distance = 0;
};

/// Finds hypotheses for pairs of sessions, and remembers what it correlated: a finished piece is correlated with
/// another only once. Not thread safe.
class HypothesisFinder {
 public:
  struct Config {
    double piece_m = 120;
    float cell_m = 0.5F;
    std::size_t most = 8;           // handed on
    std::size_t correlations = 16;  // new piece pairs in one call; those with most descriptor matches first
    int threads = 1;
  };
  explicit HypothesisFinder(const Config& config) : config_(config) {}

  /// `exhausted` (out) is false when piece pairs were left for a later call.
  std::vector<Hypothesis> find(SessionId id_a, std::span<const Keyframe> a, SessionId id_b, std::span<const Keyframe> b,
                               std::span<const MatchedPair> matches, const DescriptorFamily* family, bool& exhausted);

 private:
  struct PairKey {
    SessionId session_a, session_b;
    std::size_t begin_a, begin_b;
    auto operator<=>(const PairKey&) const = default;
  };
  /// Valid while both pieces still end where they did: the last piece of a session grows.
  struct Correlated {
    std::size_t end_a = 0, end_b = 0;
    std::vector<Hypothesis> hypotheses;
  };
  Correlated correlate_pieces(std::span<const Keyframe> a, Piece piece_a, std::span<const Keyframe> b,
                              Piece piece_b) const;
  void add_from_walls(SessionId id_a, std::span<const Keyframe> a, SessionId id_b, std::span<const Keyframe> b,
                      std::span<const MatchedPair> matches, std::vector<Hypothesis>& out, bool& exhausted);

  Config config_;
  std::map<PairKey, Correlated> correlated_;
};

/// FRAME's T_0, for each of the best yaw differences: the levelled frames of the two keyframes on each other. Empty
/// without w.
std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, const DescriptorFamily& family,
                                     std::size_t most_yaws);

}  // namespace headframe
