#include "server/station/robot_desk.hpp"

#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"

namespace headframe {
namespace {

std::string state_of(const RobotRecord& robot, bool code_is_open) {
  if (code_is_open) return "invited";
  if (robot.revoked) return "revoked";
  return robot.enrolled_s > 0 ? "enrolled" : "expired";
}

}  // namespace

std::vector<RobotRow> RobotDesk::robots() const {
  const double now_s = gate_.now_s();
  std::vector<RobotRow> rows;
  for (const RobotRecord& robot : gate_.robots()) {
    const bool open = !robot.code_digest.empty() && now_s < robot.code_expires_s;
    rows.push_back(
        {robot.name, state_of(robot, open), robot.enrolled_s, open ? robot.code_expires_s : 0, robot.rate_kib_s});
  }
  return rows;
}

std::string RobotDesk::fingerprint() const { return to_hex(fingerprint_); }

void RobotDesk::add(const std::string& robot, const std::function<void(const Result<std::string>&)>& done) {
  gate_.open(robot, [done, fingerprint = fingerprint_](const Result<std::string>& code) {
    done(code ? Result<std::string>(to_string(Enrolment{fingerprint, *code})) : code);
  });
}

void RobotDesk::revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done) {
  gate_.revoke(robot, done);
}

void RobotDesk::set_rate(const std::string& robot, std::uint64_t kib_s,
                         const std::function<void(const Result<void>&)>& done) {
  gate_.set_rate(robot, kib_s, done);
}

}  // namespace headframe
