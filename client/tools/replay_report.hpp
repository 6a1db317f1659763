#pragma once
// The output of headframe-replay: a progress bar on a terminal, occasional plain lines elsewhere.

#include <chrono>
#include <mutex>
#include <string>

#include "client/robot_client.hpp"

namespace headframe {

/// Thread safe, because transforms arrive on the link's thread.
class ReplayReport {
 public:
  explicit ReplayReport(std::size_t scans);

  void line(const std::string& text);
  void warning(const std::string& text);  // on standard error
  void step(std::size_t scans_done, const Progress& progress);
  void transforms(const SessionKey& mine, const Transforms& transforms);
  void localization(const Localization& localization);
  void trajectories(const Trajectories& trajectories);
  void coverage(const Coverage& coverage);
  void map(const MapAround& map);
  void end(const Progress& progress);

 private:
  void clear_bar();
  void draw_bar();

  std::mutex mutex_;
  const std::size_t scans_;
  const bool terminal_;
  std::string bar_;     // as shown on the terminal
  std::string status_;  // the last plain line
  std::string cut_;     // why keyframes are left out of merging, as last reported by step()
  std::chrono::steady_clock::time_point drawn_;
  std::uint64_t withdrawn_known_ = 0;  // newest revision of the withdrawals that were printed
};

/// "45 keyframes (40 acknowledged), 40 clouds (30 acknowledged), 1.2 MB sent"
std::string describe(const Progress& progress);

}  // namespace headframe
