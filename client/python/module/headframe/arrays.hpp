#pragma once
// Converts poses and clouds from and to numpy arrays.

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

/// Becomes headframe.Error in Python.
struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct BadInput : Fault {
  using Fault::Fault;
};

/// Releases the interpreter's lock while a robot is destroyed, because its thread may be waiting for the lock.
struct Unlocked {
  void operator()(RobotClient* robot) const {
    const py::gil_scoped_release others_run;
    delete robot;
  }
};

/// ValueError if it is not a rigid transform.
Pose pose_of(const Matrix4& T);
/// From arrays of shape (n) and (n, 4, 4); else ValueError.
std::vector<TrajectoryPose> trajectory_of(const ValuesOfDouble& stamps_s, const PoseArray& T_local_sensor);
inline Matrix4 matrix_of(const Pose& T) { return T.matrix(); }

/// From an array of shape (n, 3), or with more columns, of which the first three are used; else ValueError.
Points points_of(const PointArray& points);

/// From an array of shape (n); else ValueError.
std::vector<float> values_of(const ValueArray& values);

/// An array of shape (n, 3) of doubles.
py::array_t<double> array_of(const std::vector<Eigen::Vector3d>& points);
py::array_t<double> array_of(const Eigen::Vector3d& origin, const Points& points);

/// All cells that were seen: the middle of each in the component's frame (n, 2), what was seen, when last (seconds by
/// the robots' clocks, in steps of 600 s), and the number of the session that saw it last.
py::tuple cells_of(const Coverage& coverage);

}  // namespace headframe::python
