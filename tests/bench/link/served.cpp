#include "tests/bench/link/served.hpp"

#include <chrono>
#include <fstream>
#include <iterator>
#include <regex>
#include <thread>

namespace headframe::bench {

using namespace std::chrono_literals;

Result<Served> serve(const std::filesystem::path& scratch, const std::string& config) {
  std::filesystem::create_directories(scratch);
  std::ofstream(scratch / "config.toml") << config;
  const std::string log = (scratch / "server.log").string();
  std::filesystem::remove(log);
  auto process =
      test::Process::start({test::program("headframe-server"), "--data", (scratch / "data").string(), "--listen",
                            "127.0.0.1:0", "--http", "127.0.0.1:0", "--config", (scratch / "config.toml").string()},
                           log);
  if (!process) return tl::unexpected(process.error());
  static const std::regex ready("ready: robots on 127.0.0.1:([0-9]+), http on ([^,]+)");
  for (int i = 0; i < 500; ++i, std::this_thread::sleep_for(20ms)) {
    std::ifstream in(log);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    if (std::smatch match; std::regex_search(text, match, ready))
      return Served{std::move(*process), static_cast<std::uint16_t>(std::stoi(match[1])), match[2], scratch / "data"};
  }
  return failure(ErrorCode::unavailable, "the server did not get ready, see " + log);
}

}  // namespace headframe::bench
