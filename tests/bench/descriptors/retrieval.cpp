#include "tests/bench/descriptors/retrieval.hpp"

#include <algorithm>

namespace headframe::bench {
namespace {

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? -1 : static_cast<double>(part) / static_cast<double>(whole);
}

template <class Holds>
std::size_t count_where(const Answers& answers, Holds&& holds) {
  return static_cast<std::size_t>(std::count_if(answers.begin(), answers.end(), holds));
}

}  // namespace

std::size_t count_queries(const Answers& answers) {
  return count_where(answers, [](const Answer& a) { return a.answerable; });
}

double recall(const Answers& answers, std::size_t n) {
  const std::size_t found =
      count_where(answers, [n](const Answer& a) { return a.answerable && a.rank >= 1 && a.rank <= n; });
  return share(found, count_queries(answers));
}

std::vector<TradeOff> trade_off(const Answers& answers) {
  Answers nearest_first;
  std::copy_if(answers.begin(), answers.end(), std::back_inserter(nearest_first),
               [](const Answer& a) { return a.distance < std::numeric_limits<double>::infinity(); });
  std::sort(nearest_first.begin(), nearest_first.end(),
            [](const Answer& a, const Answer& b) { return a.distance < b.distance; });
  const std::size_t queries = count_queries(answers);
  std::vector<TradeOff> curve;
  if (queries == 0) return curve;
  std::size_t right = 0;
  for (std::size_t i = 0; i < nearest_first.size(); ++i) {
    right += nearest_first[i].rank == 1 ? 1 : 0;
    const bool tied = i + 1 < nearest_first.size() && nearest_first[i + 1].distance == nearest_first[i].distance;
    if (!tied) curve.push_back({share(right, queries), share(right, i + 1)});
  }
  return curve;
}

double precision_at_full_recall(const Answers& answers) {
  const auto curve = trade_off(answers);
  if (curve.empty()) return count_queries(answers) == 0 ? -1 : 0;
  const auto full = std::find_if(curve.begin(), curve.end(),
                                 [&](const TradeOff& point) { return point.recall == curve.back().recall; });
  return full->precision;
}

std::vector<double> yaw_errors_deg(const Answers& answers) {
  std::vector<double> errors;
  for (const Answer& a : answers)
    if (a.yaw_error_deg >= 0) errors.push_back(a.yaw_error_deg);
  return errors;
}

double share_top2_within_10deg(const Answers& answers) {
  const std::size_t told = count_where(answers, [](const Answer& a) { return a.yaw_top2_error_deg >= 0; });
  return share(
      count_where(answers, [](const Answer& a) { return a.yaw_top2_error_deg >= 0 && a.yaw_top2_error_deg <= 10; }),
      told);
}

void ClassCount::add(bool truth, bool told) {
  hits += truth && told ? 1 : 0;
  false_alarms += !truth && told ? 1 : 0;
  misses += truth && !told ? 1 : 0;
  others += !truth && !told ? 1 : 0;
}

double ClassCount::f1() const { return share(2 * hits, 2 * hits + false_alarms + misses); }

}  // namespace headframe::bench
