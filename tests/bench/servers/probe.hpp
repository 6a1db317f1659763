#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "client/robot_client.hpp"

namespace headframe::bench {

/// A robot in this process that adds a keyframe every 50 ms and is never killed: when is it acknowledged again?
class Probe {
 public:
  static constexpr const char* name = "probe";

  /// servers: HOST:PORT,HOST:PORT.
  static Result<std::unique_ptr<Probe>> start(const std::filesystem::path& spool, const std::string& servers,
                                              const std::string& enrolment);
  ~Probe();

  /// Seconds from `begin` until a keyframe that was added after this call is acknowledged. unavailable: none in 60 s.
  Result<double> acknowledged_after(std::chrono::steady_clock::time_point begin) const;

  /// Adds nothing more and waits until all is acknowledged; how many keyframes there are.
  Result<std::uint64_t> finish();

 private:
  explicit Probe(std::unique_ptr<RobotClient> client);

  std::unique_ptr<RobotClient> client_;
  std::atomic<std::uint64_t> added_ = 0;
  std::jthread drives_;
};

}  // namespace headframe::bench
