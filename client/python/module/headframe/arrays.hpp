#pragma once
// Poses and clouds as numpy arrays.

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>

#include <stdexcept>

#include "client/robot_client.hpp"

namespace headframe::python {

namespace py = pybind11;

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
using PointArray = py::array_t<float, py::array::c_style | py::array::forcecast>;
using ValueArray = PointArray;
using PoseArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using ValuesOfDouble = PoseArray;

/// headframe.Error
struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct BadInput : Fault {
  using Fault::Fault;
};

/// Lets go of the interpreter's lock while a robot ends: its thread may wait for it.
struct Unlocked {
  void operator()(RobotClient* robot) const {
    const py::gil_scoped_release others_run;
    delete robot;
  }
};

/// ValueError: it is no rigid transform.
Pose pose_of(const Matrix4& T);
/// From (n) and (n, 4, 4); else ValueError.
std::vector<TrajectoryPose> trajectory_of(const ValuesOfDouble& stamps_s, const PoseArray& T_local_sensor);
inline Matrix4 matrix_of(const Pose& T) { return T.matrix(); }

/// From (n, 3) or (n, more), of which the first three columns count; else ValueError.
Points points_of(const PointArray& points);

/// From (n); else ValueError.
std::vector<float> values_of(const ValueArray& values);

/// (n, 3) of doubles.
py::array_t<double> array_of(const std::vector<Eigen::Vector3d>& points);
py::array_t<double> array_of(const Eigen::Vector3d& origin, const Points& points);

/// All cells that anybody has seen: the middle of each in the component's frame (n, 2), what was seen, when last
/// (seconds of the robots' clocks, to 600 s), and the session that did, by its number.
py::tuple cells_of(const Coverage& coverage);

}  // namespace headframe::python
