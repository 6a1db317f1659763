#pragma once
// The real programs together, for system tests: a server on free ports, robots that replay session folders, the
// operator's command.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/process.hpp"

namespace headframe::test {

/// A folder of its own under the system's temporary one, removed when destroyed.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A running headframe-server.
class BaseStation {
 public:
  /// With TLS and tokens, unless insecure. Keeps its data in `data`; `config`: its TOML file, if
  /// any. Fails with what the server printed when it does
  /// not get ready.
  static Result<BaseStation> start(const std::filesystem::path& data, const std::string& listen = "127.0.0.1:0",
                                   bool insecure = false, const std::filesystem::path& config = {});

  /// One that waits for the database that another server has: returns when it stands by, with where it will serve.
  static Result<BaseStation> start_standby(const std::filesystem::path& data, const std::filesystem::path& config,
                                           bool insecure = false, const std::string& listen = "127.0.0.1:0");
  /// Returns when it serves.
  Result<void> await_ready();

  const std::string& robots() const { return robots_; }  // HOST:PORT
  const std::string& http() const { return http_; }
  Process& process() { return process_; }
  const std::string& fingerprint() const { return fingerprint_; }  // hexadecimal; empty: insecure
  std::filesystem::path token_file() const { return data_ / "operator.token"; }
  Result<std::string> token() const;  // the operator's; empty: insecure

  /// `headframe robot add`: what the robot has to be given.
  Result<std::string> enrolment(const std::string& robot) const;

  /// Options that let headframe-replay in as this robot: it is enrolled the first time, and its credential kept beside
  /// the server's data.
  Result<std::vector<std::string>> admission(const std::string& robot) const;

  /// headframe-replay --fast of a session folder, admitted, with more options if wanted.
  Result<Process> replay(const std::string& robot, const std::filesystem::path& session,
                         const std::vector<std::string>& options = {}) const;

  /// The operator's command against this server: its output and exit status.
  Result<Process::Ended> command(const std::vector<std::string>& arguments) const;

  /// `headframe atlas --json --wait 300`, parsed.
  Result<nlohmann::json> settled_atlas() const;

 private:
  BaseStation(Process process, std::filesystem::path data) : process_(std::move(process)), data_(std::move(data)) {}
  static Result<BaseStation> launch(const std::filesystem::path& data, const std::string& listen, bool insecure,
                                    const std::filesystem::path& config);
  Result<void> read_until(const std::regex& line);
  Process process_;
  std::filesystem::path data_;
  std::string robots_, http_, fingerprint_;
};

}  // namespace headframe::test
