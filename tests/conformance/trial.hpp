#pragma once
// The scenarios: each starts the client anew, with a station that has never seen it.

#include <filesystem>
#include <string>
#include <vector>

#include "tests/conformance/course.hpp"
#include "tests/conformance/findings.hpp"
#include "tests/conformance/peer.hpp"
#include "tests/support/process.hpp"

namespace headframe::conformance {

struct TrialConfig {
  std::vector<std::string> command;  // of the client, with {server} {robot} {enrol} {credential} {spool} {session}
  std::filesystem::path scratch;     // empty at first
  std::string listen = "127.0.0.1:0";
  double patience_s = 20;  // for each thing that the client has to do
};

/// A whole session over five connections, and the four ends after which a client may not come back.
std::vector<std::string> scenario_names();

/// False: there is no such scenario, or the client could not be started; what the client did wrong is in `findings`.
/// `said` gets the end of what the client printed.
Result<void> run_scenario(const std::string& name, const Course& course, const TrialConfig& config, Findings& findings,
                          std::string& said);

}  // namespace headframe::conformance
