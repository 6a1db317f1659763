#include "tests/support/truth.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

namespace headframe::test {
namespace {

std::vector<Pose> read_tum(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<Pose> poses;
  for (std::string line; std::getline(in, line);) {
    std::istringstream numbers(line);
    double t = 0;
    Eigen::Vector3d p;
    Eigen::Quaterniond q;
    if (!(numbers >> t >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w())) continue;
    poses.push_back(Eigen::Translation3d(p) * q.normalized());
  }
  return poses;
}

Pose from_rows(const nlohmann::json& numbers) {
  Pose T = Pose::Identity();
  for (std::size_t i = 0; i < 12; ++i)
    T.matrix()(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4)) = numbers.at(i);
  return T;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

TruePath read_true_path(const std::filesystem::path& recording, const std::string& robot) {
  TruePath path;
  path.T_local_sensor = read_tum(recording / robot / "poses.txt");
  path.T_world_sensor = read_tum(recording / "truth" / (robot + ".txt"));
  if (path.T_world_sensor.empty()) {
    std::ifstream in(recording / "truth.json");
    const auto truth = nlohmann::json::parse(in).at("robots").at(robot);
    const Pose T = from_rows(truth.contains("T_world_local") ? truth["T_world_local"] : truth.at("world_from_local"));
    for (const Pose& pose : path.T_local_sensor) path.T_world_sensor.push_back(T * pose);
  }
  return path;
}

OverlapError overlap_error(const TruePath& a, const TruePath& b, const Pose& T_a_b, double near_m) {
  std::vector<double> metres, degrees;
  for (std::size_t i = 0; i < a.T_local_sensor.size(); ++i)
    for (std::size_t j = 0; j < b.T_local_sensor.size(); ++j) {
      if ((a.T_world_sensor[i].translation() - b.T_world_sensor[j].translation()).norm() > near_m) continue;
      const Pose truth = a.T_world_sensor[i].inverse() * b.T_world_sensor[j];
      const Pose estimate = a.T_local_sensor[i].inverse() * T_a_b * b.T_local_sensor[j];
      metres.push_back((truth.translation() - estimate.translation()).norm());
      degrees.push_back(rotation_angle_rad(truth.inverse() * estimate) * 180 / std::numbers::pi);
    }
  if (metres.empty()) return {};
  return {metres.size(), median(metres), median(degrees)};
}

OverlapError nearest_overlap_error(const TruePath& a, const TruePath& b, const Pose& T_a_b) {
  for (const double near_m : {8.0, 16.0, 30.0})
    if (const OverlapError error = overlap_error(a, b, T_a_b, near_m); error.pairs > 0) return error;
  return {};
}

}  // namespace headframe::test
