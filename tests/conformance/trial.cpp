#include "tests/conformance/trial.hpp"

#include <functional>

#include "tests/conformance/client_trial.hpp"

namespace headframe::conformance {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t thin_bytes_per_s = 4000;

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
  talk->listen(trial.patience());
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
  const auto message = peer->read(Clock::now() + trial.patience());
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
    said = trial.said();
    return {};
  }
  std::string names;
  for (const auto& known : scenario_names()) names += " " + known;
  return failure(ErrorCode::invalid_argument, "no scenario '" + name + "'; there are:" + names);
}

}  // namespace headframe::conformance
