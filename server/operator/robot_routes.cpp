#include "server/operator/routes.hpp"

#include "server/operator/robot_json.hpp"

namespace headframe::routes {
namespace {

Result<RobotAdmin*> robot_admin(const Context& context) {
  if (context.robots != nullptr) return context.robots;
  return failure(ErrorCode::refused, "this server runs with --insecure: robots come in without enrolling");
}

}  // namespace

Result<Reply> robots(const Query&, const Context& context) {
  const auto admin = robot_admin(context);
  if (!admin) return tl::unexpected(admin.error());
  return json(
      robots_json((*admin)->robots(), (*admin)->fingerprint(), (*admin)->address(), context.station.robot_sites()));
}

Result<Reply> add_robot(const Query& query, const Context& context) {
  const auto admin = robot_admin(context);
  const auto robot = required(query, "robot");
  if (!admin || !robot) return tl::unexpected(admin ? robot.error() : admin.error());
  return Later{[admin = *admin, robot = *robot](const std::function<void(Ready)>& answer) {
    admin->add(robot, [robot, answer](const Result<std::string>& enrolment) {
      answer(enrolment ? json(enrolment_json(robot, *enrolment), 201) : error_reply(enrolment.error()));
    });
  }};
}

Result<Reply> rate_robot(const Query& query, const Context& context) {
  const auto admin = robot_admin(context);
  if (!admin) return tl::unexpected(admin.error());
  const auto robot = required(query, "robot"), text = required(query, "kib_s");
  if (!robot || !text) return tl::unexpected(robot ? text.error() : robot.error());
  const auto kib_s = whole_number(query, "kib_s", 0, 1e9);
  if (!kib_s) return tl::unexpected(kib_s.error());
  return Later{[admin = *admin, robot = *robot, kib_s = *kib_s](const std::function<void(Ready)>& answer) {
    admin->set_rate(robot, kib_s, [kib_s, answer](const Result<void>& done) {
      answer(done ? json("{\"kib_s\":" + std::to_string(kib_s) + "}\n") : error_reply(done.error()));
    });
  }};
}

Result<Reply> revoke_robot(const Query& query, const Context& context) {
  const auto admin = robot_admin(context);
  const auto robot = required(query, "robot");
  if (!admin || !robot) return tl::unexpected(admin ? robot.error() : admin.error());
  const auto act = [admin = *admin, robot = *robot](const std::function<void(Ready)>& answer) {
    admin->revoke(robot, [answer](const Result<void>& revoked) {
      answer(revoked ? json("{\"revoked\":true}\n") : error_reply(revoked.error()));
    });
  };
  return Later{act, true};
}

}  // namespace headframe::routes
