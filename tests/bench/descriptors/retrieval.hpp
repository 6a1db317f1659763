#pragma once
// Counting: how good are the answers of a place database? Pure.

#include <cstddef>
#include <limits>
#include <vector>

namespace headframe::bench {

/// A right answer lies within right_m of the query and saw at least right_pct of the same surface. Both limits are
/// right.
constexpr double right_m = 5, right_pct = 30;
inline bool is_right(double distance_m, double overlap_pct) {
  return distance_m <= right_m && overlap_pct >= right_pct;
}

/// What a keyframe of one drive was answered by the database of another.
struct Answer {
  bool answerable = false;  // the other drive has a right keyframe: only then it is a query of the recall
  std::size_t rank = 0;     // of the first right neighbour, from 1; 0: none was found
  double distance = std::numeric_limits<double>::infinity();  // of the first neighbour in the family's own measure
  double yaw_error_deg = -1;       // of the best yaw against the right neighbour nearest by q; -1: no yaw was told
  double yaw_top2_error_deg = -1;  // of the better of the two best
};
using Answers = std::vector<Answer>;

std::size_t count_queries(const Answers& answers);

/// Share of the queries with a right answer among the first n neighbours; -1 without queries.
double recall(const Answers& answers, std::size_t n);

/// First neighbours taken for true when they are near enough, all those of one distance together, by growing distance.
/// Keyframes that have no right answer count: taking their neighbour for true is wrong.
struct TradeOff {
  double recall = 0;     // queries with a right first neighbour that is taken, of all queries
  double precision = 1;  // right ones of those taken
};
std::vector<TradeOff> trade_off(const Answers& answers);

/// Precision where just no right first neighbour is lost; 0 when none is right, -1 without queries.
double precision_at_full_recall(const Answers& answers);

/// The yaw errors of queries that were told a yaw, and the share of these with one of the two best within 10 deg (-1
/// without any).
std::vector<double> yaw_errors_deg(const Answers& answers);
double share_top2_within_10deg(const Answers& answers);

/// Of a class of two, one of which is looked for.
struct ClassCount {
  std::size_t hits = 0, false_alarms = 0, misses = 0, others = 0;

  void add(bool truth, bool told);
  /// Harmonic mean of precision and recall; -1 when nothing was there to find and nothing was told.
  double f1() const;
};

}  // namespace headframe::bench
