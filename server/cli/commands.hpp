#pragma once
// The subcommands of `headframe`. Results go to stdout, progress and faults to stderr. Each returns the exit status.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "server/cli/http_client.hpp"

namespace headframe {

enum ExitCode : int { exit_ok = 0, exit_failed = 1, exit_usage = 2, exit_waited_out = 3 };

/// The line that the server wrote for people, or at least its status.
Error error_of(const HttpResponse& response);

/// Of an export. Empty: what the server takes without it.
struct MapRequest {
  std::string component;  // its id, or a session of it
  std::string file;
  std::string format;  // empty: the file's ending
  std::string frame;   // component or grid
  std::optional<double> voxel_m;
  std::optional<int> scale;  // of a plan: 1:scale
};

/// Sessions are named "robot/session", or by the robot or the label when only one has it.
class Commands {
 public:
  /// json: print the API's JSON instead of tables.
  Commands(HttpEndpoint endpoint, bool json) : endpoint_(std::move(endpoint)), json_(json) {}

  Result<int> status();
  Result<int> sessions();
  /// With wait_s: once nothing is pending; prints the atlas all the same when time runs out.
  Result<int> atlas(std::optional<double> wait_s);
  /// Every alignment with its evidence; of pairs that came to nothing at most so many, the newest.
  Result<int> alignments(int most_rejected);
  /// What changed in the mine since a date (seconds since 1970), as merged sessions tell.
  Result<int> changes(double since_s);
  /// "confirm", "refuse", "retract" or "undo" of the alignment with this id. refused: to confirm one that other
  /// sessions contradict or that is improbable, unless all_the_same.
  Result<int> decide(const std::string& decision, const std::string& alignment, bool all_the_same);
  /// Why two sessions are or are not merged; each "robot/session", or "robot" when it has just one.
  Result<int> explain(const std::string& a, const std::string& b);
  /// b lies so on a: x, y, z and yaw in degrees, or pairs of points in a file. Prints what came of it; exit_failed: it
  /// was not kept.
  Result<int> place(const std::string& a, const std::string& b, const std::vector<double>& at, const std::string& file);
  /// Queues an attempt for every session, then as atlas(wait_s) with progress; without wait_s as long as it takes.
  Result<int> merge(std::optional<double> wait_s);
  /// Shows status and sessions, again every `every_s`, on a terminal in place; `times` 0: until it is ended. With json:
  /// one line of status each time.
  Result<int> watch(double every_s, int times);

  // export_commands.cpp
  Result<int> export_map(const MapRequest& request);
  /// CSV when the file ends in .csv, TUM otherwise. frame: as MapRequest's.
  Result<int> trajectory(const std::string& session, const std::string& file, const std::string& frame);

  /// All of the base station as one file that nobody else may read.
  Result<int> backup(const std::string& file);

  // session_commands.cpp
  Result<int> rename(const std::string& session, const std::string& label);
  Result<int> anchor(const std::string& session);
  Result<int> request_clouds(const std::string& session);
  Result<int> quarantine(const std::string& session, const std::string& reason);
  Result<int> release(const std::string& session);
  /// "archive", "restore", "freeze" or "thaw"; `done` says it of the session.
  Result<int> tend(const std::string& session, const char* action, const char* done);
  /// Prints the note where `text` is none.
  Result<int> note(const std::string& session, const std::optional<std::string>& text);
  /// Says what hangs on it; refused, unless all_the_same.
  Result<int> remove_session(const std::string& session, bool all_the_same);
  // store_commands.cpp
  /// How much room there is, and which clouds would go for it.
  Result<int> store();
  /// Says which clouds would go for so many MiB, 0: all that may; refused, unless all_the_same.
  Result<int> let_go(int mib, bool all_the_same);

  // servers.cpp
  /// The servers that are there: which serves, and which wait to take over.
  Result<int> servers();

  Result<int> list_surveys();
  /// The file holds the API's JSON, or control points when it ends in .csv. accept: also points that do not fit each
  /// other.
  Result<int> set_survey(const std::string& session, const std::string& file, bool accept);
  Result<int> drop_survey(const std::string& session);
  /// How far the two sessions' surfaces lie apart; with json the points too, so many of each session at most.
  Result<int> overlay(const std::string& alignment, int most);

  // sites.cpp
  Result<int> list_sites();
  /// Of sessions that the robot begins from now on, and of one that is there; empty: no site.
  Result<int> set_robot_site(const std::string& robot, const std::string& site);
  Result<int> set_session_site(const std::string& session, const std::string& site);

  // robots.cpp
  Result<int> list_robots();
  // operators.cpp
  Result<int> list_operators();
  /// Prints the token, which is told this once.
  Result<int> add_operator(const std::string& name, const std::string& role, double days);
  Result<int> revoke_operator(const std::string& name);
  /// Prints the one string that the robot needs.
  Result<int> add_robot(const std::string& robot);
  Result<int> revoke_robot(const std::string& robot);
  /// 0: no limit of its own.
  Result<int> rate_robot(const std::string& robot, std::uint64_t kib_s);

 private:
  struct Waited;
  using HttpRequest = std::function<Result<HttpResponse>(HttpClient client, const HttpWatch& watch)>;
  /// The body of the answer with this status; who waits at a terminal for more than a second is told for how long.
  Result<std::string> wanted(const HttpRequest& ask, int status = 200, double silence_s = 60);
  Result<std::string> posted(const std::string& target, int status, const std::string& body = {});
  Result<std::string> removed(const std::string& target);
  using View = std::function<std::string(const nlohmann::json&)>;
  /// Prints what was answered: the JSON as it came, or the view of it.
  Result<int> printed(const Result<std::string>& body, const View& view);
  Result<nlohmann::json> session_named(const std::string& wanted);
  Result<std::string> component_named(const std::string& wanted);
  Result<void> check_confirm(const std::string& alignment);
  Result<std::string> fetched(const std::string& target);
  Result<Waited> wait_for_idle(std::optional<double> wait_s, bool progress);
  Result<int> print_waited(const Waited& waited);
  Result<std::size_t> download(const std::string& target, const std::string& file, bool secret = false);

  HttpEndpoint endpoint_;
  bool json_;
};

}  // namespace headframe
