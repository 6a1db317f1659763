#include "tests/conformance/client_trial.hpp"

#include <fstream>
#include <map>

#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"
#include "common/security/tls.hpp"

namespace headframe::conformance {
namespace {

using namespace std::chrono_literals;
using test::Process;

constexpr auto start_up = 60s;  // of a client on a busy machine

std::string replaced(std::string text, const std::map<std::string, std::string>& by) {
  for (const auto& [what, with] : by)
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
      text.replace(at, what.size(), with);
  return text;
}

}  // namespace

Trial::Trial(const std::string& name, const Course& course, const TrialConfig& config, Findings& findings)
    : folder_(config.scratch / name),
      config_(config),
      findings_(findings),
      patience_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(config.patience_s))),
      listener_(config.listen),
      pem_(make_identity().value()),
      tls_(server_tls(pem_).value()),
      code_(random_secret(code_bytes)),
      judge_(course, {robot_, code_}, findings) {
  std::filesystem::create_directories(folder_);
  if (!std::filesystem::exists(config.scratch / "recording")) course.write(config.scratch / "recording");
}

Result<void> Trial::start(const std::string& pinned) {
  const std::string enrolment = to_string(Enrolment{pinned.empty() ? fingerprint_of(pem_).value() : pinned, code_});
  const std::map<std::string, std::string> by{{"{server}", listener_.address()},
                                              {"{robot}", robot_},
                                              {"{enrol}", enrolment},
                                              {"{credential}", (folder_ / "credential").string()},
                                              {"{spool}", (folder_ / "spool").string()},
                                              {"{session}", (config_.scratch / "recording").string()}};
  std::vector<std::string> argv;
  for (const auto& part : config_.command) argv.push_back(replaced(part, by));
  if (argv.front().find('/') == std::string::npos) argv.insert(argv.begin(), "/usr/bin/env");  // looks in PATH
  auto started = Process::start(argv, log().string());
  if (!started) return tl::unexpected(started.error());
  client_.emplace(std::move(*started));
  return {};
}

std::unique_ptr<Peer> Trial::next(const std::string& awaited) {
  auto peer = within(std::exchange(started_, true) ? patience_ : std::max<Clock::duration>(patience_, start_up));
  if (!peer) findings_.wrong("comes-back", "the client did not connect: " + awaited);
  return peer;
}

std::unique_ptr<Peer> Trial::within(Clock::duration most) {
  const auto until = Clock::now() + most;
  int socket = -1;
  while (socket < 0 && Clock::now() < until &&
         !(client_ && client_->poll() >= 0 && Clock::now() > until - most + absence))
    socket = listener_.accept(std::min(until, Clock::now() + 50ms));
  return socket < 0 ? nullptr : std::make_unique<Peer>(socket, tls_);
}

std::unique_ptr<Conversation> Trial::talk(Peer& peer) {
  auto talk = std::make_unique<Conversation>(peer, judge_, findings_, station_, patience_);
  return talk->greet() ? std::move(talk) : nullptr;
}

void Trial::expect_the_end(const std::string& after) {
  if (within(2500ms)) findings_.wrong("came-back", "the client connected again after " + after);
}

std::string Trial::said() const {
  std::ifstream in(log());
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return text.size() > 2000 ? text.substr(text.size() - 2000) : text;
}

}  // namespace headframe::conformance
