#include "tests/support/base_station.hpp"

#include <unistd.h>

#include <fstream>

namespace headframe::test {

using namespace std::chrono_literals;

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "headframe-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder " + name);
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Result<BaseStation> BaseStation::launch(const std::filesystem::path& data, const std::string& listen, bool insecure,
                                        const std::filesystem::path& config) {
  std::vector<std::string> argv{
      program("headframe-server"), "--data", data.string(), "--listen", listen, "--http", "127.0.0.1:0"};
  if (insecure) argv.emplace_back("--insecure");
  if (!config.empty()) argv.insert(argv.end(), {"--config", config.string()});
  auto process = Process::start(argv);
  if (!process) return tl::unexpected(process.error());
  return BaseStation(std::move(*process), data);
}

/// The line has where robots and operators are served.
Result<void> BaseStation::read_until(const std::regex& wanted) {
  static const std::regex identity("headframe-server fingerprint: ([0-9a-f]+)");
  std::string printed;
  while (true) {
    const auto line = process_.read_line(30s);
    if (!line)
      return failure(ErrorCode::unavailable, "the server did not get ready: " + printed + line.error().message);
    std::smatch match;
    if (std::regex_match(*line, match, identity)) fingerprint_ = match[1];
    if (std::regex_match(*line, match, wanted)) {
      robots_ = match[1];
      http_ = match[2];
      return {};
    }
    printed += *line + "\n";
  }
}

Result<void> BaseStation::await_ready() {
  static const std::regex ready("headframe-server ready: robots on ([^,]+), http on ([^,]+), data in .*");
  return read_until(ready);
}

Result<BaseStation> BaseStation::start(const std::filesystem::path& data, const std::string& listen, bool insecure,
                                       const std::filesystem::path& config) {
  auto station = launch(data, listen, insecure, config);
  if (!station) return station;
  if (auto done = station->await_ready(); !done) return tl::unexpected(done.error());
  return station;
}

Result<BaseStation> BaseStation::start_standby(const std::filesystem::path& data, const std::filesystem::path& config,
                                               bool insecure, const std::string& listen) {
  static const std::regex stands_by("headframe-server stands by: .* robots on ([^,]+), http on ([^,]+), data in .*");
  auto station = launch(data, listen, insecure, config);
  if (!station) return station;
  if (auto done = station->read_until(stands_by); !done) return tl::unexpected(done.error());
  return station;
}

Result<std::string> BaseStation::token() const {
  if (fingerprint_.empty()) return std::string();
  std::ifstream file(token_file());
  std::string token;
  if (std::getline(file, token)) return token;
  return failure(ErrorCode::unavailable, "no token in " + token_file().string());
}

Result<std::string> BaseStation::enrolment(const std::string& robot) const {
  const auto ended = command({"robot", "add", robot, "--json"});
  if (!ended) return tl::unexpected(ended.error());
  const auto json = nlohmann::json::parse(ended->output, nullptr, false);
  if (ended->status != 0 || !json.contains("enrolment"))
    return failure(ErrorCode::unavailable, "headframe robot add: " + ended->output);
  return json.at("enrolment").get<std::string>();
}

Result<std::vector<std::string>> BaseStation::admission(const std::string& robot) const {
  if (fingerprint_.empty()) return std::vector<std::string>{"--insecure"};
  const auto credential = std::filesystem::path(data_.string() + "-" + robot + ".credential");
  std::vector<std::string> options{"--credential", credential.string()};
  if (std::filesystem::exists(credential)) return options;
  const auto enrolled = enrolment(robot);
  if (!enrolled) return tl::unexpected(enrolled.error());
  options.insert(options.end(), {"--enrol", *enrolled});
  return options;
}

Result<Process> BaseStation::replay(const std::string& robot, const std::filesystem::path& session,
                                    const std::vector<std::string>& options) const {
  const auto admitted = admission(robot);
  if (!admitted) return tl::unexpected(admitted.error());
  std::vector<std::string> argv{program("headframe-replay"), "--server", robots_, "--robot", robot, "--fast"};
  argv.insert(argv.end(), admitted->begin(), admitted->end());
  argv.insert(argv.end(), options.begin(), options.end());
  argv.push_back(session.string());
  return Process::start(argv);
}

Result<Process::Ended> BaseStation::command(const std::vector<std::string>& arguments) const {
  std::vector<std::string> argv{program("headframe"), "--http", http_};
  if (!fingerprint_.empty()) argv.insert(argv.end(), {"--token-file", token_file().string()});
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  auto process = Process::start(argv);
  if (!process) return tl::unexpected(process.error());
  return process->wait(400s);
}

Result<nlohmann::json> BaseStation::settled_atlas() const {
  const auto ended = command({"atlas", "--json", "--wait", "300"});
  if (!ended) return tl::unexpected(ended.error());
  if (ended->status != 0) return failure(ErrorCode::unavailable, "headframe atlas: " + ended->output);
  auto json = nlohmann::json::parse(ended->output, nullptr, false);
  if (json.is_discarded()) return failure(ErrorCode::bad_input, "headframe atlas printed no JSON: " + ended->output);
  return json;
}

}  // namespace headframe::test
