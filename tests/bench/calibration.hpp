#pragma once
// Is a placement of probability p right p of the time?

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/result.hpp"

namespace headframe::bench {

/// Counts placements by the probability that the verdict gave them, in ten bins. Not thread safe.
class Calibration {
 public:
  void add(double probability, bool right, const std::string& mine);

  /// The expected calibration error: how far each bin's share of right placements lies from its mean probability,
  /// weighed by the placements in it. 0 without placements.
  double error() const;

  /// ece, placements, right, false (wrong ones that reach the probability at which merges are accepted), mines.
  nlohmann::json json() const;
  /// One line, and one for each bin that holds placements.
  void print() const;
  /// The reliability plot: probability to the right, share that is right upwards. unavailable: it can not be written.
  Result<void> draw(const std::filesystem::path& png) const;

 private:
  struct Bin {
    int placements = 0, right = 0;
    double sum = 0;  // of the probabilities
    double mean() const { return sum / placements; }
    double share() const { return static_cast<double>(right) / placements; }
  };
  int total(int Bin::*count) const;

  std::array<Bin, 10> bins_;
  int false_ = 0;
  std::set<std::string> mines_;
};

}  // namespace headframe::bench
