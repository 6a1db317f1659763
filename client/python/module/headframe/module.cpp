// The Python module headframe._robot: the robot library with numpy arrays. __init__.pyi documents each call.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "client/python/module/headframe/arrays.hpp"
#include "client/robot_client.hpp"
#include "common/endpoint.hpp"

namespace headframe::python {
namespace {

/// Converts failures to Python exceptions: headframe.Error for faults of the library, its subclass BadInput for an
/// unusable scan, ValueError for wrong arguments.
template <class T>
T value_of(Result<T> result) {
  if (!result && result.error().code == ErrorCode::invalid_argument) throw py::value_error(result.error().message);
  if (!result && result.error().code == ErrorCode::bad_input) throw BadInput(result.error().message);
  if (!result) throw Fault(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Wraps a Python callable for the link's thread: it is called with the interpreter's lock, and an exception that it
/// raises is printed and not passed on. None: no callback.
template <class Told>
std::function<void(const Told&)> callback_of(const py::object& callable) {
  if (callable.is_none()) return {};
  const auto release = [](py::object* held) {
    const py::gil_scoped_acquire lock;
    delete held;
  };
  const std::shared_ptr<py::object> kept(new py::object(callable), release);
  return [kept](const Told& told) {
    const py::gil_scoped_acquire lock;
    try {
      (*kept)(told);
    } catch (py::error_already_set& raised) {
      raised.discard_as_unraisable("a callback of headframe");
    }
  };
}

std::chrono::milliseconds milliseconds(double s) { return std::chrono::milliseconds(static_cast<long>(s * 1000)); }

CloudPolicy policy_of(const std::string& name) {
  if (name == "all") return CloudPolicy::all;
  if (name == "on_request") return CloudPolicy::on_request;
  if (name == "never") return CloudPolicy::never;
  throw py::value_error("clouds is \"" + name + "\"; give all, on_request or never");
}

std::unique_ptr<RobotClient, Unlocked> open(const std::string& robot, const std::string& spool,
                                            const std::string& server, const std::string& enrolment,
                                            const std::string& session, const std::string& credential,
                                            const std::string& fingerprint, bool insecure, const Sensor& sensor,
                                            const std::string& family, const std::string& clouds, double bytes_per_s,
                                            bool provisional, bool intensity) {
  RobotConfig config;
  const std::vector<Endpoint> peers = value_of(parse_peers(server));
  config.robot = robot;
  config.spool = spool;
  config.host = peers.front().host;
  config.port = peers.front().port;
  config.more_servers.assign(peers.begin() + 1, peers.end());
  config.enrolment = enrolment;
  config.session = session;
  config.credential = credential;
  config.fingerprint = fingerprint;
  config.insecure = insecure;
  config.sensor = sensor;
  config.family = family;
  config.clouds = policy_of(clouds);
  config.bytes_per_s = bytes_per_s;
  config.provisional = provisional;
  config.intensity = intensity;
  const py::gil_scoped_release others_run;
  return std::unique_ptr<RobotClient, Unlocked>(value_of(RobotClient::open(config)).release());
}

bool add_scan(RobotClient& robot, double stamp_s, const Matrix4& T_local_sensor, const PointArray& points,
              const std::optional<ValueArray>& intensity) {
  const Pose T = pose_of(T_local_sensor);
  const Points copied = points_of(points);
  const auto values = intensity ? values_of(*intensity) : std::vector<float>{};
  const py::gil_scoped_release others_run;
  return value_of(robot.add_scan(stamp_s, T, copied, values));
}

void say_live(RobotClient& robot, std::optional<double> battery, const std::string& health,
              const std::optional<Matrix4>& T_local_sensor, double stamp_s) {
  LiveState state{stamp_s, std::nullopt, battery, health};
  if (T_local_sensor) state.T_local_sensor = pose_of(*T_local_sensor);
  const py::gil_scoped_release others_run;
  value_of(robot.live(state));
}

void update_poses(RobotClient& robot, const std::map<std::uint64_t, Matrix4>& T_local_sensor) {
  std::vector<KeyframePose> poses;
  poses.reserve(T_local_sensor.size());
  for (const auto& [sequence, T] : T_local_sensor) poses.push_back({sequence, pose_of(T)});
  const py::gil_scoped_release others_run;
  value_of(robot.update_poses(poses));
}

py::tuple correct(RobotClient& robot, const ValuesOfDouble& stamps_s, const PoseArray& T_local_sensor,
                  double least_moved_m, double least_turned_rad, bool later_ones) {
  const std::vector<TrajectoryPose> trajectory = trajectory_of(stamps_s, T_local_sensor);
  CorrectionRules rules;
  rules.least_moved_m = least_moved_m;
  rules.least_turned_rad = least_turned_rad;
  rules.later_ones = later_ones;
  const CorrectedKeyframes done = [&] {
    const py::gil_scoped_release others_run;
    return value_of(robot.correct(trajectory, rules));
  }();
  py::dict moved;
  for (const KeyframePose& pose : done.moved) moved[py::cast(pose.sequence)] = matrix_of(pose.T_local_sensor);
  return py::make_tuple(moved, done.matched);
}

void finish(RobotClient& robot, double patience_s) {
  const py::gil_scoped_release others_run;
  value_of(robot.finish(milliseconds(patience_s)));
}

void ask_sphere(RobotClient& robot, const Eigen::Vector3d& centre, double radius_m, double resolution_m,
                const std::optional<MapAround>& since, const py::object& callback) {
  const auto told = callback_of<MapAround>(callback);
  const py::gil_scoped_release others_run;
  robot.map_around({SphereRegion{centre, radius_m}, resolution_m, since ? since->held : HeldVersion{}}, told);
}

void describe_values(py::module_& m) {
  py::class_<SessionKey>(m, "SessionKey")
      .def_readonly("robot", &SessionKey::robot)
      .def_readonly("session", &SessionKey::session)
      .def("__eq__", [](const SessionKey& a, const SessionKey& b) { return a == b; })
      .def("__hash__", [](const SessionKey& k) { return std::hash<std::string>()(k.robot + "/" + k.session); })
      .def("__repr__", [](const SessionKey& k) { return k.robot + "/" + k.session; });
  py::class_<Sensor>(m, "Sensor")
      .def(py::init([](const std::string& model, int beams, float up, float down, float range) {
             return Sensor{model, beams, up, down, range};
           }),
           py::arg("model"), py::arg("beams") = 0, py::arg("fov_up_deg") = 0, py::arg("fov_down_deg") = 0,
           py::arg("max_range_m") = 0);
  py::class_<Progress>(m, "Progress")
      .def_readonly("keyframes", &Progress::keyframes)
      .def_readonly("keyframes_acknowledged", &Progress::keyframes_acknowledged)
      .def_readonly("pose_updates", &Progress::pose_updates)
      .def_readonly("pose_updates_acknowledged", &Progress::pose_updates_acknowledged)
      .def_readonly("pose_updates_unsupported", &Progress::pose_updates_unsupported)
      .def_readonly("clouds_waiting", &Progress::clouds_waiting)
      .def_readonly("clouds_acknowledged", &Progress::clouds_acknowledged)
      .def_readonly("clouds_dropped", &Progress::clouds_dropped)
      .def_readonly("bytes_sent", &Progress::bytes_sent)
      .def_readonly("connected", &Progress::connected)
      .def_readonly("refused", &Progress::refused)
      .def_readonly("hold", &Progress::hold)
      .def_readonly("cut", &Progress::cut)
      .def_readonly("link_error", &Progress::link_error);
  py::class_<Transforms::Support>(m, "Support")
      .def_readonly("probability", &Transforms::Support::probability)
      .def_readonly("merged_with", &Transforms::Support::merged_with)
      .def_readonly("merges", &Transforms::Support::merges)
      .def_readonly("shared_m", &Transforms::Support::shared_m)
      .def_readonly("confirmed", &Transforms::Support::confirmed)
      .def_readonly("deviation_m", &Transforms::Support::deviation_m)
      .def_readonly("deviation_rad", &Transforms::Support::deviation_rad)
      .def("covariance", &Transforms::Support::covariance, py::arg("away_m") = Eigen::Vector3d(0, 0, 0));
  py::class_<Transforms>(m, "Transforms")
      .def_readonly("revision", &Transforms::revision)
      .def_readonly("component", &Transforms::component)
      .def_readonly("anchor", &Transforms::anchor)
      .def_property_readonly("T_component_session",
                             [](const Transforms& t) {
                               py::dict all;
                               for (const auto& s : t.sessions)
                                 all[py::cast(s.session)] = matrix_of(s.T_component_session);
                               return all;
                             })
      .def("support",
           [](const Transforms& t, const SessionKey& session) -> py::object {
             const auto* support = t.support(session);
             return support ? py::cast(*support) : py::none();
           })
      .def("T_mine_other", [](const Transforms& t, const SessionKey& mine, const SessionKey& other) -> py::object {
        const auto T = t.T_mine_other(mine, other);
        return T ? py::cast(matrix_of(*T)) : py::none();
      });
  py::class_<Localization>(m, "Localization")
      .def_property_readonly("found", [](const Localization& l) { return l.state == Localization::State::found; })
      .def_property_readonly("supported",
                             [](const Localization& l) { return l.state != Localization::State::unsupported; })
      .def_property_readonly("T_component_session",
                             [](const Localization& l) { return matrix_of(l.T_component_session); })
      .def_property_readonly("T_component_sensor",
                             [](const Localization& l) { return matrix_of(l.T_component_sensor); })
      .def_property_readonly("covariance",
                             [](const Localization& l) { return Eigen::Matrix<double, 6, 6>(l.covariance); })
      .def_readonly("keyframe", &Localization::keyframe)
      .def_readonly("component", &Localization::component)
      .def_readonly("anchor", &Localization::anchor)
      .def_readonly("session", &Localization::session)
      .def_readonly("merged", &Localization::merged)
      .def_readonly("probability", &Localization::probability)
      .def_readonly("shared_m", &Localization::shared_m)
      .def_readonly("awaited_m", &Localization::awaited_m)
      .def_readonly("missing", &Localization::missing);
}

void describe_surroundings(py::module_& m) {
  py::class_<SurroundingsTold>(m, "Surroundings")
      .def_property_readonly("told", [](const SurroundingsTold& s) { return s.state == SurroundingsTold::State::told; })
      .def_property_readonly("supported",
                             [](const SurroundingsTold& s) { return s.state != SurroundingsTold::State::unsupported; })
      .def_property_readonly("T_component_local",
                             [](const SurroundingsTold& s) { return matrix_of(s.T_component_local); })
      .def_readonly("revision", &SurroundingsTold::revision)
      .def_readonly("component", &SurroundingsTold::component)
      .def_readonly("anchor", &SurroundingsTold::anchor)
      .def_readonly("missing", &SurroundingsTold::missing);
  py::class_<Trajectories::Path>(m, "Path")
      .def_readonly("session", &Trajectories::Path::session)
      .def_readonly("last_stamp_s", &Trajectories::Path::last_stamp_s)
      .def_readonly("age_s", &Trajectories::Path::age_s)
      .def_property_readonly("points", [](const Trajectories::Path& p) { return array_of(p.p_local_m); });
  py::class_<Trajectories, SurroundingsTold>(m, "Trajectories").def_readonly("paths", &Trajectories::paths);
  py::class_<Coverage, SurroundingsTold>(m, "Coverage")
      .def_readonly("sessions", &Coverage::sessions)
      .def("cells", [](const Coverage& c) { return cells_of(c); })
      .def("at",
           [](const Coverage& c, const Eigen::Vector3d& p_local) { return static_cast<int>(c.at(p_local).what); });
  py::class_<MapAround>(m, "MapAround")
      .def_readonly("refused", &MapAround::refused)
      .def_readonly("revision", &MapAround::revision)
      .def_readonly("clouds", &MapAround::clouds)
      .def_readonly("clouds_left_out", &MapAround::clouds_left_out)
      .def_readonly("since", &MapAround::since)
      .def_property_readonly("points", [](const MapAround& map) { return array_of(map.origin_local_m, map.points); });
}

/// A property of the robot, read without the interpreter's lock: the library holds its own lock while it destroys a
/// replaced callback, and that needs the interpreter's lock.
template <class Value>
auto property(Value (RobotClient::*read)() const) {
  return [read](const RobotClient& robot) {
    const py::gil_scoped_release others_run;
    return (robot.*read)();
  };
}

template <class Told>
auto subscription(void (RobotClient::*subscribe)(const std::function<void(const Told&)>&)) {
  return [subscribe](RobotClient& robot, const py::object& callable) {
    auto callback = callback_of<Told>(callable);
    const py::gil_scoped_release others_run;
    (robot.*subscribe)(callback);
  };
}

}  // namespace

PYBIND11_MODULE(_robot, m) {
  const py::object fault = py::register_exception<Fault>(m, "Error", PyExc_RuntimeError);
  py::register_exception<BadInput>(m, "BadInput", fault);
  describe_values(m);
  describe_surroundings(m);
  const py::call_guard<py::gil_scoped_release> others_run;
  py::class_<RobotClient, std::unique_ptr<RobotClient, Unlocked>>(m, "Robot")
      .def(py::init(&open), py::arg("robot"), py::kw_only(), py::arg("spool"), py::arg("server"),
           py::arg("enrolment") = "", py::arg("session") = "", py::arg("credential") = "", py::arg("fingerprint") = "",
           py::arg("insecure") = false, py::arg("sensor") = Sensor{}, py::arg("family") = RobotConfig().family,
           py::arg("clouds") = "all", py::arg("bytes_per_s") = 0.0, py::arg("provisional") = false,
           py::arg("intensity") = true)
      .def("add_scan", &add_scan, py::arg("stamp_s"), py::arg("T_local_sensor"), py::arg("points"),
           py::arg("intensity") = std::nullopt)
      .def("update_poses", &update_poses, py::arg("T_local_sensor"))
      .def("correct", &correct, py::arg("stamps_s"), py::arg("T_local_sensor"),
           py::arg("least_moved_m") = CorrectionRules().least_moved_m,
           py::arg("least_turned_rad") = CorrectionRules().least_turned_rad,
           py::arg("later_ones") = CorrectionRules().later_ones)
      .def("on_transforms", subscription(&RobotClient::on_transform), py::arg("callback"))
      .def("localize", subscription(&RobotClient::localize), py::arg("callback"))
      .def("trajectories", subscription(&RobotClient::trajectories), py::arg("callback"))
      .def("coverage", subscription(&RobotClient::coverage), py::arg("callback"))
      .def("map_around", &ask_sphere, py::arg("centre"), py::arg("radius_m"), py::arg("resolution_m") = 0.2,
           py::arg("since") = std::nullopt, py::arg("callback"))
      .def("live", &say_live, py::arg("battery") = std::nullopt, py::arg("health") = "",
           py::arg("T_local_sensor") = std::nullopt, py::arg("stamp_s") = 0.0)
      .def("trigger", &RobotClient::trigger, py::arg("reason") = "", others_run)
      .def("finish", &finish, py::arg("patience_s") = 30.0)
      .def("close", &RobotClient::close, others_run)
      .def_property_readonly("transforms", property(&RobotClient::transforms))
      .def_property_readonly("last_keyframe", property(&RobotClient::last_keyframe))
      .def_property_readonly("session", property(&RobotClient::session))
      .def_property_readonly("warnings", property(&RobotClient::warnings))
      .def_property_readonly("progress", property(&RobotClient::progress));
}

}  // namespace headframe::python
