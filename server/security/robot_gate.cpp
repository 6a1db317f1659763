#include "server/security/robot_gate.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace headframe {
namespace {

double system_now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double steady_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

RobotGate::Seams filled(RobotGate::Seams seams) {
  if (!seams.now_s) seams.now_s = system_now_s;
  if (!seams.steady_s) seams.steady_s = steady_now_s;
  if (!seams.ended) seams.ended = [](const std::string&, const std::string&) {};
  if (!seams.rated) seams.rated = [](const std::string&, std::uint64_t) {};
  return seams;
}

}  // namespace

RobotGate::RobotGate(Store& store, Seams seams, const AttemptLimits& limits, RevocationLog* revocations)
    : store_(store),
      seams_(filled(std::move(seams))),
      clock_(seams_.now_s, seams_.steady_s),
      attempts_(limits),
      lines_(limits),
      revocations_(revocations) {}

Result<void> RobotGate::restore() {
  const auto robots = store_.robots();
  if (!robots) return tl::unexpected(robots.error());
  registry_.restore(*robots);
  for (const RobotRecord& robot : *robots) {
    seams_.rated(robot.name, robot.rate_kib_s);
    clock_.at_least(std::max(robot.enrolled_s, robot.code_expires_s - RobotRegistry::code_lifetime_s));
  }
  if (revocations_) revoke_again(*robots);
  return {};
}

/// Repeats revocations that were made while the disk was full, if the process ended before they were stored. Not for a
/// robot that has enrolled again since.
void RobotGate::revoke_again(const std::vector<RobotRecord>& stored) {
  for (const RevocationLog::Waiting& waiting : revocations_->waiting()) {
    const auto it = std::find_if(stored.begin(), stored.end(),
                                 [&](const RobotRecord& robot) { return robot.name == waiting.entry.robot; });
    const bool same = it != stored.end() && it->token_digest == waiting.entry.token_digest;
    const auto change = same && !it->revoked ? registry_.revoke(it->name) : failure(ErrorCode::not_found, "");
    if (!change) {
      revocations_->remove(waiting.slot);
      continue;
    }
    spdlog::warn("robot {} is revoked, as was said before the last end of the server", it->name);
    store_.write(PutRobot{change->after},
                 [revocations = revocations_, slot = waiting.slot](const Result<void>& written) {
                   if (written) revocations->remove(slot);
                 });
  }
}

void RobotGate::admit(const std::string& robot, const Credential& shown, const boost::asio::ip::address& from,
                      AttemptLimiter::Time now, const std::function<void(const Result<void>&)>& done) {
  if (registry_.holds(robot, shown.token)) return done({});
  if (!attempts_.allowed(from, now))
    return done(failure(ErrorCode::unavailable,
                        "too many failed attempts from " + from.to_string() + ": try again in a minute"));
  const std::lock_guard lock(order_);
  const auto admitted = registry_.admit(robot, shown, now_s());
  if (!admitted) {
    attempts_.failed(from, now);
    return done(tl::unexpected(admitted.error()));
  }
  if (!*admitted) return done({});
  keep(**admitted, [this, robot, done](const Result<void>& stored) {
    if (stored) {
      spdlog::info("robot {} has enrolled", robot);
      seams_.ended(robot, "it has enrolled anew");
    }
    done(stored);
  });
}

bool RobotGate::worth_a_line(const boost::asio::ip::address& from, AttemptLimiter::Time now) {
  const bool worth = lines_.allowed(from, now);
  lines_.failed(from, now);
  return worth;
}

void RobotGate::open(const std::string& robot, const std::function<void(const Result<std::string>&)>& done) {
  const std::lock_guard lock(order_);
  auto opened = registry_.open(robot, now_s());
  if (!opened) return done(tl::unexpected(opened.error()));
  keep(opened->change, [robot, code = opened->code, done](const Result<void>& stored) {
    if (!stored) return done(tl::unexpected(stored.error()));
    spdlog::info("robot {} may enrol", robot);
    done(code);
  });
}

void RobotGate::revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done) {
  const std::lock_guard lock(order_);
  const auto revoked = registry_.revoke(robot);
  if (!revoked) return done(tl::unexpected(revoked.error()));
  seams_.ended(robot, "it was revoked");
  spdlog::info("robot {} was revoked", robot);
  // Not undone if it cannot be stored: better to lock out a robot than to let it in.
  const auto slot = revocations_ ? revocations_->add({robot, revoked->after.token_digest})
                                 : Result<std::size_t>(failure(ErrorCode::unavailable, "there is no list"));
  if (!slot) return store_.write(PutRobot{revoked->after}, done);
  store_.write(PutRobot{revoked->after}, [revocations = revocations_, slot = *slot](const Result<void>& written) {
    if (written) revocations->remove(slot);
  });
  done({});
}

void RobotGate::set_rate(const std::string& robot, std::uint64_t kib_s,
                         const std::function<void(const Result<void>&)>& done) {
  const std::lock_guard lock(order_);
  const auto change = registry_.set_rate(robot, kib_s);
  if (!change) return done(tl::unexpected(change.error()));
  keep(*change, [this, robot, kib_s, done](const Result<void>& stored) {
    if (stored) {
      seams_.rated(robot, kib_s);
      spdlog::info("robot {} may send {}", robot, kib_s == 0 ? "what it can" : std::to_string(kib_s) + " KiB/s");
    }
    done(stored);
  });
}

void RobotGate::keep(const RobotRegistry::Change& change, const std::function<void(const Result<void>&)>& done) {
  store_.write(PutRobot{change.after}, [this, change, done](const Result<void>& stored) {
    if (!stored) registry_.take_back(change);
    done(stored);
  });
}

}  // namespace headframe
