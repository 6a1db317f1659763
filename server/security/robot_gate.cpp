#include "server/security/robot_gate.hpp"

#include <spdlog/spdlog.h>

namespace headframe {
namespace {

double system_now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

RobotGate::Seams filled(RobotGate::Seams seams) {
  if (!seams.now_s) seams.now_s = system_now_s;
  if (!seams.ended) seams.ended = [](const std::string&, const std::string&) {};
  if (!seams.rated) seams.rated = [](const std::string&, std::uint64_t) {};
  return seams;
}

}  // namespace

RobotGate::RobotGate(Store& store, Seams seams, const AttemptLimits& limits)
    : store_(store), seams_(filled(std::move(seams))), attempts_(limits), lines_(limits) {}

Result<void> RobotGate::restore() {
  const auto robots = store_.robots();
  if (!robots) return tl::unexpected(robots.error());
  registry_.restore(*robots);
  for (const RobotRecord& robot : *robots) seams_.rated(robot.name, robot.rate_kib_s);
  return {};
}

void RobotGate::admit(const std::string& robot, const Credential& shown, const boost::asio::ip::address& from,
                      AttemptLimiter::Time now, const std::function<void(const Result<void>&)>& done) {
  if (registry_.holds(robot, shown.token)) return done({});
  if (!attempts_.allowed(from, now))
    return done(failure(ErrorCode::unavailable,
                        "too many failed attempts from " + from.to_string() + ": try again in a minute"));
  const std::lock_guard lock(order_);
  const auto admitted = registry_.admit(robot, shown, seams_.now_s());
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
  auto opened = registry_.open(robot, seams_.now_s());
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
  store_.write(PutRobot{revoked->after}, done);  // not taken back when it fails: better locked out than let in
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
