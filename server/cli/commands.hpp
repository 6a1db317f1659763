#pragma once
// The subcommands of `headframe`. Results go to stdout, progress and faults to stderr. Each returns the exit status.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/cli/http_client.hpp"

namespace headframe {

enum ExitCode : int { exit_ok = 0, exit_failed = 1, exit_usage = 2, exit_waited_out = 3 };

class Commands {
 public:
  /// json: print the API's JSON instead of tables.
  Commands(HttpEndpoint endpoint, bool json) : endpoint_(std::move(endpoint)), json_(json) {}

  Result<int> status();
  Result<int> sessions();
  /// With wait_s: once nothing is pending; prints the atlas all the same when time runs out.
  Result<int> atlas(std::optional<double> wait_s);
  /// Every alignment with its evidence.
  Result<int> alignments();
  /// "confirm", "refuse", "retract" or "undo" of the alignment with this id.
  Result<int> decide(const std::string& decision, const std::string& alignment);
  /// Why two sessions are or are not merged; each "robot/session", or "robot" when it has just one.
  Result<int> explain(const std::string& a, const std::string& b);
  /// Queues an attempt for every session, then as atlas(wait_s) with progress; without wait_s as long as it takes.
  Result<int> merge(std::optional<double> wait_s);
  /// Shows status and sessions, again every `every_s`, on a terminal in place; `times` 0: until it is ended. With json:
  /// one line of status each time.
  Result<int> watch(double every_s, int times);
  /// The format is the file's extension: .ply, .pcd or .las.
  Result<int> export_map(const std::string& component, const std::string& file, std::optional<double> voxel_m);
  /// session: "robot/session", or "robot" when it has just one. CSV when the file ends in .csv, TUM otherwise.
  Result<int> trajectory(const std::string& session, const std::string& file);

  // robots.cpp
  Result<int> list_robots();
  /// Prints the one string that the robot needs.
  Result<int> add_robot(const std::string& robot);
  Result<int> revoke_robot(const std::string& robot);
  /// 0: no limit of its own.
  Result<int> rate_robot(const std::string& robot, std::uint64_t kib_s);

 private:
  struct Waited;
  Result<std::string> posted(const std::string& target, int status);
  Result<std::string> fetched(const std::string& target, double silence_s = 30);
  Result<Waited> wait_for_idle(std::optional<double> wait_s, bool progress);
  Result<int> print_waited(const Waited& waited);
  Result<std::size_t> download(const std::string& target, const std::string& file);

  HttpEndpoint endpoint_;
  bool json_;
};

}  // namespace headframe
