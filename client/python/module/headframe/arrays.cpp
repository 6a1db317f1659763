#include "client/python/module/headframe/arrays.hpp"

namespace headframe::python {

Pose pose_of(const Matrix4& T) {
  constexpr double tolerance = 1e-3;  // for matrices that were rounded to single precision, or printed
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const bool is_rigid = T.allFinite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < tolerance &&
                        R.determinant() > 0 && (T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < tolerance;
  if (!is_rigid) throw py::value_error("T_local_sensor is no rigid transform: 4 x 4, a rotation, 0 0 0 1 below");
  Pose out = Pose::Identity();
  out.matrix() = T;
  return orthonormalised(out);
}

std::vector<TrajectoryPose> trajectory_of(const ValuesOfDouble& stamps_s, const PoseArray& T_local_sensor) {
  const bool fits = stamps_s.ndim() == 1 && T_local_sensor.ndim() == 3 && T_local_sensor.shape(1) == 4 &&
                    T_local_sensor.shape(2) == 4 && T_local_sensor.shape(0) == stamps_s.shape(0);
  if (!fits) throw py::value_error("a trajectory is stamps of (n) and poses of (n, 4, 4)");
  std::vector<TrajectoryPose> out;
  out.reserve(static_cast<std::size_t>(stamps_s.shape(0)));
  for (py::ssize_t i = 0; i < stamps_s.shape(0); ++i)
    out.push_back({*stamps_s.data(i), pose_of(Eigen::Map<const Matrix4>(T_local_sensor.data(i, 0, 0)))});
  return out;
}

Points points_of(const PointArray& points) {
  if (points.ndim() != 2 || points.shape(1) < 3) throw py::value_error("points has to be an array of (n, 3)");
  const auto p = points.unchecked<2>();
  Points out(static_cast<std::size_t>(p.shape(0)));
  for (py::ssize_t i = 0; i < p.shape(0); ++i) out[static_cast<std::size_t>(i)] = {p(i, 0), p(i, 1), p(i, 2)};
  return out;
}

std::vector<float> values_of(const ValueArray& values) {
  if (values.ndim() != 1) throw py::value_error("intensity has to be an array of (n), as many as points");
  return {values.data(), values.data() + values.size()};
}

py::array_t<double> array_of(const std::vector<Eigen::Vector3d>& points) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  auto to = out.mutable_unchecked<2>();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (py::ssize_t axis = 0; axis < 3; ++axis) to(static_cast<py::ssize_t>(i), axis) = points[i][axis];
  return out;
}

py::array_t<double> array_of(const Eigen::Vector3d& origin, const Points& points) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  auto to = out.mutable_unchecked<2>();
  for (std::size_t i = 0; i < points.size(); ++i)
    for (py::ssize_t axis = 0; axis < 3; ++axis)
      to(static_cast<py::ssize_t>(i), axis) = origin[axis] + static_cast<double>(points[i][axis]);
  return out;
}

py::tuple cells_of(const Coverage& coverage) {
  std::vector<double> middles, times_s;
  std::vector<std::uint8_t> what;
  std::vector<std::uint32_t> sessions;
  for (const auto& [index, tile] : coverage.tiles)
    for (std::size_t i = 0; i < tile->cells.size(); ++i) {
      const CoverageCell& cell = tile->cells[i];
      if (cell.what == 0) continue;
      const std::size_t row = i / coverage_tile_cells, column = i % coverage_tile_cells;
      middles.push_back((index.x * coverage_tile_cells + static_cast<double>(column) + 0.5) * coverage_cell_m);
      middles.push_back((index.y * coverage_tile_cells + static_cast<double>(row) + 0.5) * coverage_cell_m);
      what.push_back(cell.what);
      times_s.push_back(cell.last_seen * coverage_time_s);
      sessions.push_back(cell.session);
    }
  const auto count = static_cast<py::ssize_t>(what.size());
  return py::make_tuple(py::array_t<double>({count, py::ssize_t{2}}, middles.data()),
                        py::array_t<std::uint8_t>(count, what.data()), py::array_t<double>(count, times_s.data()),
                        py::array_t<std::uint32_t>(count, sessions.data()));
}

}  // namespace headframe::python
