#include "tests/conformance/trial.hpp"

#include <csignal>
#include <fstream>
#include <functional>
#include <map>

#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"
#include "common/security/tls.hpp"
#include "tests/conformance/conversation.hpp"

namespace headframe::conformance {
namespace {

using namespace std::chrono_literals;
using test::Process;

constexpr auto absence = 300ms;  // what is not to come has not come by then
constexpr std::uint64_t thin_bytes_per_s = 4000;

std::string replaced(std::string text, const std::map<std::string, std::string>& by) {
  for (const auto& [what, with] : by)
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
      text.replace(at, what.size(), with);
  return text;
}

/// One client with a station of its own.
class Trial {
 public:
  Trial(const std::string& name, const Course& course, const TrialConfig& config, Findings& findings)
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

  /// pinned: the fingerprint that the client is told, 32 bytes; empty: the right one.
  Result<void> start(const std::string& pinned = "") {
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

  std::filesystem::path log() const { return folder_ / "client.log"; }
  Findings& findings() { return findings_; }
  Judge& judge() { return judge_; }
  const std::string& robot() const { return robot_; }
  Clock::duration patience() const { return patience_; }

  /// The client's next connection, its handshake not yet done; null: it did not come, which is reported.
  std::unique_ptr<Peer> next(const std::string& awaited) {
    auto peer = within(patience_);
    if (!peer) findings_.wrong("comes-back", "the client did not connect: " + awaited);
    return peer;
  }
  std::unique_ptr<Peer> within(Clock::duration most) {
    const auto until = Clock::now() + most;
    int socket = -1;
    while (socket < 0 && Clock::now() < until &&
           !(client_ && client_->poll() >= 0 && Clock::now() > until - most + absence))
      socket = listener_.accept(std::min(until, Clock::now() + 50ms));
    return socket < 0 ? nullptr : std::make_unique<Peer>(socket, tls_);
  }
  std::unique_ptr<Conversation> talk(Peer& peer) {
    auto talk = std::make_unique<Conversation>(peer, judge_, findings_, station_, patience_);
    return talk->greet() ? std::move(talk) : nullptr;
  }

  /// Nobody comes back after this, whatever time it is given.
  void expect_the_end(const std::string& after) {
    if (within(2500ms)) findings_.wrong("came-back", "the client connected again after " + after);
  }

 private:
  const std::string robot_ = "conformance-robot";
  const std::filesystem::path folder_;
  const TrialConfig& config_;
  Findings& findings_;
  const Clock::duration patience_;
  Listener listener_;
  const std::string pem_;
  boost::asio::ssl::context tls_;
  const std::string code_;
  Judge judge_;
  Station station_;
  std::optional<Process> client_;
};

/// The first Welcome is lost: the hello comes again with the same token, and the code.
bool lost_welcome(Trial& trial) {
  auto peer = trial.next("at first");
  if (!peer) return false;
  const auto talk = trial.talk(*peer);
  if (!talk) return false;
  if (const auto early = peer->read(Clock::now() + absence))
    trial.findings().wrong("before-welcome", "a message comes before the Welcome");
  return true;
}

/// No acknowledgement: 64 keyframes come and no more. Then a few, and the link breaks.
bool window(Trial& trial, std::uint64_t& durable) {
  auto peer = trial.next("after a connection that ended without a Welcome");
  const auto talk = peer ? trial.talk(*peer) : nullptr;
  if (!talk) return false;
  talk->welcome(0, {}, true);
  if (!peer->send_bytes(std::string("\0\0\0\5\xfa\x06\2hi", 9))) return false;  // a body of number 111
  v1::ServerMessage later;
  later.mutable_ping()->set_nonce(1001);
  later.mutable_ping()
      ->GetReflection()
      ->MutableUnknownFields(later.mutable_ping())
      ->AddLengthDelimited(99, "a later field");
  talk->say(later);
  if (!talk->settle()) return false;
  if (!talk->until([&] { return talk->last() >= 64; }, "keyframes", "64 keyframes; the session is long enough"))
    return false;
  if (!talk->settle()) return false;
  talk->listen(absence);
  talk->acknowledge(3);
  if (!talk->until([&] { return talk->last() >= 67; }, "keyframes", "the keyframes behind an acknowledgement"))
    return false;
  durable = 10;  // more is on the disk than was acknowledged
  return true;
}

/// The robot goes on where the Welcome says, holds, and sends clouds that are asked for.
bool resumed(Trial& trial, std::uint64_t durable, std::uint64_t& all) {
  auto peer = trial.next("after the link broke");
  const auto talk = peer ? trial.talk(*peer) : nullptr;
  if (!talk) return false;
  talk->welcome(durable);
  talk->hold("conformance: the disk is full");
  talk->listen(absence);
  talk->hold("");
  // One keyframe is never acknowledged, so that the client stays.
  while (talk->until([&] { return talk->last() > durable + 1; }, "", "")) {
    durable = talk->last() - 1;
    talk->acknowledge(durable);
    if (talk->backlog() == 0) {
      talk->listen(absence);
      if (talk->last() == durable + 1) break;
    }
  }
  all = talk->last();
  if (!talk->settle()) return false;
  talk->request({5, 2, 9, 1});
  if (!talk->until([&] { return talk->has_cloud(5) && talk->has_cloud(2) && talk->has_cloud(9) && talk->has_cloud(1); },
                   "request", "clouds 5, 2, 9 and 1, or that they will not come"))
    return false;
  if (trial.judge().policy() == CloudPolicy::never) return true;
  talk->acknowledge_cloud(5);
  talk->acknowledge_cloud(2);
  talk->refuse_cloud(9);
  // On a link this thin two clouds take seconds, so that it breaks in the middle of one.
  talk->pace(thin_bytes_per_s);
  talk->request({12, 13});
  if (!talk->until([&] { return talk->begun(12); }, "request", "the cloud of keyframe 12")) return false;
  talk->listen(absence);
  trial.findings().check(!talk->whole(12) || !talk->whole(13), "rate",
                         "two clouds come within a moment, though the LinkPolicy allows " +
                             std::to_string(thin_bytes_per_s) + " bytes a second");
  return true;
}

/// What was begun begins anew, and an error that passes passes.
bool begun_anew(Trial& trial, std::uint64_t all) {
  auto peer = trial.next("after the link broke in a cloud");
  const auto talk = peer ? trial.talk(*peer) : nullptr;
  if (!talk) return false;
  talk->welcome(all - 1, {2, 5});
  talk->tell_transforms(trial.robot(), talk->session());
  talk->request({12, 3});
  if (!talk->until([&] { return talk->has_cloud(12) && talk->has_cloud(3); }, "request", "clouds 12 and 3"))
    return false;
  if (!talk->settle()) return false;
  talk->error(v1::ERROR_KIND_OVERLOADED, false);
  talk->listen(absence);
  return true;
}

/// The database is lost: everything comes again, and then the client may go.
void lost_database(Trial& trial, std::uint64_t all) {
  auto peer = trial.next("after an error that is not permanent");
  const auto talk = peer ? trial.talk(*peer) : nullptr;
  if (!talk) return;
  talk->welcome(0);
  const auto acknowledge = [&] {
    if (talk->last() > 0) talk->acknowledge(talk->last());
    for (const auto sequence : std::vector<std::uint64_t>(talk->unacknowledged_clouds()))
      talk->acknowledge_cloud(sequence);
  };
  std::uint64_t last = 0;
  while (talk->last() < all && talk->until([&] { return talk->last() > last; }, "lost-database",
                                           "all keyframes again, from 1, for a station that says it has none")) {
    last = talk->last();
    acknowledge();
  }
  const auto most = Clock::now() + trial.patience();
  while (!talk->said_goodbye() && !talk->closed() && Clock::now() < most) {
    acknowledge();
    talk->listen(50ms);
  }
  trial.findings().check(talk->said_goodbye() || !talk->closed(), "goodbye",
                         "the client closed without a Goodbye when all was acknowledged");
  if (!talk->said_goodbye()) return;  // a robot that stays needs none
  talk->listen(absence);
  trial.findings().check(talk->closed(), "goodbye", "the client does not close its sending side after the Goodbye");
}

void session(Trial& trial) {
  std::uint64_t durable = 0, all = 0;
  if (lost_welcome(trial) && window(trial, durable) && resumed(trial, durable, all) && begun_anew(trial, all))
    lost_database(trial, all);
}

void another_server(Trial& trial) {
  auto peer = trial.next("at first");
  if (!peer || !peer->handshake(Clock::now() + trial.patience())) return;  // it saw the certificate and left
  const auto message = peer->read(Clock::now() + absence);
  trial.findings().check(!message && peer->trouble() != Peer::Trouble::bad_frame, "pin",
                         "the client says hello to a server whose certificate it was not told to trust");
}

/// After what is said to its hello the client may neither go on nor come back.
void ends_for_good(Trial& trial, const std::string& after, const v1::ServerMessage& answer) {
  auto peer = trial.next("at first");
  const auto talk = peer ? trial.talk(*peer) : nullptr;
  if (!talk) return;
  talk->say(answer);
  if (answer.has_error()) peer->end_sending();  // a server closes after it; else the client has to
  const auto message = peer->read(Clock::now() + 2s);
  trial.findings().check(!message && peer->trouble() == Peer::Trouble::closed, "goes-on",
                         "the client goes on, or does not close, after " + after);
  peer.reset();
  trial.expect_the_end(after);
}

v1::ServerMessage refusal() {
  v1::ServerMessage message;
  message.mutable_error()->set_kind(v1::ERROR_KIND_REFUSED);
  message.mutable_error()->set_message("conformance: this error is part of the trial");
  message.mutable_error()->set_permanent(true);
  return message;
}

v1::ServerMessage welcome(std::uint32_t version, std::uint64_t durable) {
  v1::ServerMessage message;
  message.mutable_welcome()->set_protocol_version(version);
  message.mutable_welcome()->set_durable_keyframes(durable);
  return message;
}

using Scenario = std::function<void(Trial&)>;

const std::vector<std::pair<std::string, Scenario>>& scenarios() {
  static const std::vector<std::pair<std::string, Scenario>> all{
      {"session", session},
      {"another-server", another_server},
      {"refused", [](Trial& t) { ends_for_good(t, "a permanent error", refusal()); }},
      {"other-version", [](Trial& t) { ends_for_good(t, "a Welcome of protocol version 2", welcome(2, 0)); }},
      {"old-copy",
       [](Trial& t) { ends_for_good(t, "a Welcome that says more keyframes than it has", welcome(1, 1'000'000)); }}};
  return all;
}

std::string end_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return text.size() > 2000 ? text.substr(text.size() - 2000) : text;
}

}  // namespace

std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const auto& [name, run] : scenarios()) names.push_back(name);
  return names;
}

Result<void> run_scenario(const std::string& name, const Course& course, const TrialConfig& config, Findings& findings,
                          std::string& said) {
  for (const auto& [known, run] : scenarios()) {
    if (known != name) continue;
    Trial trial(name, course, config, findings);
    if (auto started = trial.start(name == "another-server" ? std::string(32, 'x') : ""); !started) return started;
    run(trial);
    said = end_of(trial.log());
    return {};
  }
  std::string names;
  for (const auto& known : scenario_names()) names += " " + known;
  return failure(ErrorCode::invalid_argument, "no scenario '" + name + "'; there are:" + names);
}

}  // namespace headframe::conformance
