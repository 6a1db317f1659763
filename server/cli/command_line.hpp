#pragma once
// What the command line of `headframe` takes: its commands and their options.

#include <CLI/CLI.hpp>

#include "server/cli/commands.hpp"

namespace headframe {

/// As they were given; their defaults are here alone.
struct Options {
  std::string http = "127.0.0.1:7448", token_file, fingerprint, authorities;
  bool json = false;
  std::optional<double> wait_s;
  std::optional<std::string> note;
  double every_s = 1;
  int times = 0, most = 10000, rejected = 1000, mib = 0;
  std::vector<double> at;
  MapRequest map;
  std::string person, role = "operate";
  double days = 30;
  std::string session, file, frame, label, reason, robot, site, alignment, a, b, shell = "bash";
  std::int64_t kib_s = 0;
  double since_s = 0;
  bool all_the_same = false;
  std::function<Result<int>(Commands&)> command;
};

inline constexpr const char* session_help = "robot/session, or the robot or the label when just one has it";

/// Adds subcommands to `app`: each has --json, and sets what is to be run.
inline auto adder(CLI::App& app, Options& options) {
  return [&app, &options](const char* name, const char* what, auto run) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_flag("--json", options.json, "Print JSON");
    sub->callback([&options, run] { options.command = run; });
    return sub;
  };
}

// Each adds its commands to the app, which keeps a reference to the options.
void add_look_commands(CLI::App& app, Options& options);
void add_pair_commands(CLI::App& app, Options& options);
void add_export_commands(CLI::App& app, Options& options);
void add_store_commands(CLI::App& app, Options& options);
void add_session_commands(CLI::App& app, Options& options);
void add_robot_commands(CLI::App& app, Options& options);
void add_site_commands(CLI::App& app, Options& options);
void add_operator_commands(CLI::App& app, Options& options);

}  // namespace headframe
