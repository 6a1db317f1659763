// headframe-conformance: plays a base station against any client, and says what the client gets wrong.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>

#include "tests/conformance/trial.hpp"

namespace headframe::conformance {
namespace {

int failed(const std::string& message) {
  std::fprintf(stderr, "headframe-conformance: %s\n", message.c_str());
  return 2;
}

int run(TrialConfig config, std::vector<std::string> scenarios) {
  std::string scratch = (std::filesystem::temp_directory_path() / "headframe-conformance-XXXXXX").string();
  if (::mkdtemp(scratch.data()) == nullptr) return failed(scratch + ": can not be made");
  config.scratch = scratch;
  if (scenarios.empty()) scenarios = scenario_names();
  const Course course;
  int wrong = 0, passed = 0;
  for (const auto& name : scenarios) {
    Findings findings;
    std::string said;
    const auto done = run_scenario(name, course, config, findings, said);
    if (!done) return failed(done.error().message);
    passed += findings.passed();
    for (const auto& [kind, finding] : findings.found()) {
      ++wrong;
      std::printf("WRONG %s (%s, %d times): %s\n", kind.c_str(), name.c_str(), finding.times, finding.first.c_str());
    }
    if (!findings.found().empty() && !said.empty()) std::printf("the client said: %s\n", said.c_str());
    std::fflush(stdout);
  }
  std::error_code ignored;
  std::filesystem::remove_all(config.scratch, ignored);
  if (wrong == 0)
    std::printf("headframe-conformance: nothing wrong in %d checks\n", passed);
  else
    std::printf("headframe-conformance: %d kinds of faults, %d checks held\n", wrong, passed);
  return wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace headframe::conformance

int main(int argc, char** argv) {
  headframe::conformance::TrialConfig config;
  std::vector<std::string> scenarios;
  CLI::App app{
      "Plays a base station against a robot's client and says what the client gets wrong. Exit status 0: nothing."};
  app.add_option(
      "--scenario", scenarios,
      "only this one, may be given several times: session, another-server, refused, other-version, old-copy");
  app.add_option("--listen", config.listen, "HOST:PORT")->capture_default_str();
  app.add_option("--patience", config.patience_s, "seconds for each thing that the client has to do")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.footer(
      "After --, the client's COMMAND; in it {server} {robot} {enrol} {credential} {spool} {session} stand for what it "
      "is to use.");
  const auto dashes = std::find(argv, argv + argc, std::string("--"));
  if (dashes != argv + argc) config.command.assign(dashes + 1, argv + argc);
  try {
    app.parse(static_cast<int>(dashes - argv), argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (config.command.empty()) return headframe::conformance::failed("give the client's command after --");
  std::signal(SIGPIPE, SIG_IGN);  // a client that closes is part of the trial
  try {
    return headframe::conformance::run(config, scenarios);
  } catch (const std::exception& fault) {
    return headframe::conformance::failed(fault.what());
  }
}
