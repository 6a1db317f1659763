#include "tests/bench/link/served.hpp"

#include <chrono>
#include <fstream>
#include <iterator>
#include <regex>
#include <thread>

namespace headframe::bench {

using namespace std::chrono_literals;

namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

bool Served::is_active() const { return text_of(log).find("headframe-server ready: ") != std::string::npos; }

Result<Served> serve(const std::filesystem::path& scratch, const std::string& config, const ServedAt& at) {
  std::filesystem::create_directories(scratch);
  std::ofstream(scratch / "config.toml") << config;
  const std::filesystem::path log = scratch / "server.log";
  std::filesystem::remove(log);
  auto process =
      test::Process::start({test::program("headframe-server"), "--data", (scratch / "data").string(), "--listen",
                            at.listen, "--http", at.http, "--config", (scratch / "config.toml").string()},
                           log.string());
  if (!process) return tl::unexpected(process.error());
  static const std::regex there("(?:ready: |falls free, )robots on 127.0.0.1:([0-9]+), http on ([^,]+)");
  for (int i = 0; i < 1500 && process->poll() < 0; ++i, std::this_thread::sleep_for(20ms)) {
    const std::string text = text_of(log);
    if (std::smatch match; std::regex_search(text, match, there))
      return Served{std::move(*process), static_cast<std::uint16_t>(std::stoi(match[1])), match[2], scratch / "data",
                    log};
  }
  return failure(ErrorCode::unavailable, "the server did not get ready: " + text_of(log));
}

Result<void> make_known_as(const Served& active, const std::filesystem::path& scratch) {
  std::error_code fault;
  std::filesystem::create_directories(scratch / "data", fault);
  for (const char* file : {"identity.pem", "operator.token"})
    if (!fault) std::filesystem::copy_file(active.data / file, scratch / "data" / file, fault);
  if (fault) return failure(ErrorCode::unavailable, scratch.string() + ": " + fault.message());
  return {};
}

}  // namespace headframe::bench
