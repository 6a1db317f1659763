#include "tests/support/base_station.hpp"

#include <unistd.h>

#include <regex>

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

Result<BaseStation> BaseStation::start(const std::filesystem::path& data, const std::string& listen) {
  auto process = Process::start({program("headframe-server"), "--data", data.string(), "--listen", listen, "--http",
                                 "127.0.0.1:0", "--insecure"});
  if (!process) return tl::unexpected(process.error());
  static const std::regex ready("headframe-server ready: robots on ([^,]+), http on ([^,]+), data in .*");
  std::string printed;
  while (true) {
    const auto line = process->read_line(30s);
    if (!line)
      return failure(ErrorCode::unavailable, "the server did not get ready: " + printed + line.error().message);
    std::smatch match;
    if (std::regex_match(*line, match, ready)) return BaseStation(std::move(*process), match[1], match[2]);
    printed += *line + "\n";
  }
}

Result<Process> BaseStation::replay(const std::string& robot, const std::filesystem::path& session,
                                    const std::vector<std::string>& options) const {
  std::vector<std::string> argv{
      program("headframe-replay"), "--server", robots_, "--robot", robot, "--insecure", "--fast"};
  argv.insert(argv.end(), options.begin(), options.end());
  argv.push_back(session.string());
  return Process::start(argv);
}

Result<Process::Ended> BaseStation::command(const std::vector<std::string>& arguments) const {
  std::vector<std::string> argv{program("headframe"), "--http", http_};
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
