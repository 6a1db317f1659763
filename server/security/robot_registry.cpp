#include "server/security/robot_registry.hpp"

#include "common/security/secret.hpp"
#include "common/wire/convert.hpp"

namespace headframe {
namespace {

bool is_token_of(const RobotRecord& robot, const std::string& token) {
  return !token.empty() && same_secret(sha256(token), robot.token_digest);
}

tl::unexpected<Error> refused(const std::string& name, const std::string& why) {
  return failure(ErrorCode::refused, "robot " + name + ": " + why);
}

tl::unexpected<Error> unknown(const std::string& name) {
  return failure(ErrorCode::not_found, "there is no robot \"" + name + "\"");
}

std::string ask_for_another(const std::string& name) {
  return "; ask the operator for another: headframe robot add " + name;
}

}  // namespace

void RobotRegistry::restore(const std::vector<RobotRecord>& robots) {
  const std::lock_guard lock(mutex_);
  for (const RobotRecord& robot : robots) robots_[robot.name] = robot;
}

std::vector<RobotRecord> RobotRegistry::robots() const {
  const std::lock_guard lock(mutex_);
  std::vector<RobotRecord> all;
  all.reserve(robots_.size());
  for (const auto& [name, robot] : robots_) all.push_back(robot);
  return all;
}

Result<RobotRegistry::Opened> RobotRegistry::open(const std::string& name, double now_s) {
  if (auto ok = check_name("robot", name); !ok) return failure(ErrorCode::invalid_argument, ok.error().message);
  Opened opened{random_secret(code_bytes), {}};
  const std::lock_guard lock(mutex_);
  const auto known = robots_.find(name);
  if (known != robots_.end())
    opened.change.before = known->second;
  else if (robots_.size() >= most_robots)
    return failure(ErrorCode::refused, "there are " + std::to_string(most_robots) + " robots already");
  RobotRecord& robot = robots_[name];
  robot.name = name;
  robot.code_digest = sha256(opened.code);
  robot.code_expires_s = now_s + code_lifetime_s;
  opened.change.after = robot;
  return opened;
}

Result<RobotRegistry::Change> RobotRegistry::revoke(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto known = robots_.find(name);
  if (known == robots_.end()) return unknown(name);
  Change change{{}, known->second};
  known->second.revoked = true;
  known->second.code_digest.clear();
  change.after = known->second;
  return change;
}

Result<RobotRegistry::Change> RobotRegistry::set_rate(const std::string& name, std::uint64_t kib_s) {
  if (kib_s > most_rate_kib_s)
    return failure(ErrorCode::invalid_argument, "a rate of " + std::to_string(kib_s) + " KiB/s; give up to " +
                                                    std::to_string(most_rate_kib_s) + ", or 0 for no limit");
  const std::lock_guard lock(mutex_);
  const auto known = robots_.find(name);
  if (known == robots_.end()) return unknown(name);
  Change change{{}, known->second};
  known->second.rate_kib_s = kib_s;
  change.after = known->second;
  return change;
}

Result<std::optional<RobotRegistry::Change>> RobotRegistry::admit(const std::string& name, const Credential& shown,
                                                                  double now_s) {
  if (shown.token.empty()) return refused(name, "it shows no credential" + ask_for_another(name));
  const std::lock_guard lock(mutex_);
  const auto known = robots_.find(name);
  const bool is_known = known != robots_.end();
  const bool token_fits = is_known && is_token_of(known->second, shown.token);
  if (token_fits && !known->second.revoked) return std::nullopt;
  if (shown.code.empty())  // only a robot with its token learns that it was revoked
    return refused(name, (token_fits ? "it was revoked" : "this is not its credential") + ask_for_another(name));
  if (!is_known || known->second.code_digest.empty() || !same_secret(sha256(shown.code), known->second.code_digest))
    return refused(name, "this enrolment code is not for it, or was used" + ask_for_another(name));
  if (now_s >= known->second.code_expires_s)
    return refused(name, "this enrolment code has expired" + ask_for_another(name));
  Change change{{}, known->second};
  known->second = {name, sha256(shown.token), "", 0, now_s, false, known->second.rate_kib_s};
  change.after = known->second;
  return change;
}

bool RobotRegistry::holds(const std::string& name, const std::string& token) const {
  const std::lock_guard lock(mutex_);
  const auto known = robots_.find(name);
  return known != robots_.end() && !known->second.revoked && is_token_of(known->second, token);
}

void RobotRegistry::take_back(const Change& change) {
  const std::lock_guard lock(mutex_);
  const auto known = robots_.find(change.after.name);
  if (known == robots_.end() || !(known->second == change.after)) return;  // it was changed again since
  if (change.before)
    known->second = *change.before;
  else
    robots_.erase(known);
}

}  // namespace headframe
