#pragma once
// The recorded session that a client is given to play: made here, so that everything it sends can be checked.

#include <filesystem>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"
#include "common/session/keyframe.hpp"

namespace headframe::conformance {

/// A robot's drive through a tunnel with niches on one side, its sensor tilted all the time, so that a mirrored
/// direction, an unlevelled scan or a pose the wrong way round shows. Deterministic.
class Course {
 public:
  struct Scan {
    double stamp_s = 0;
    Pose T_local_sensor = Pose::Identity();
    Points points_sensor;
    float spaciousness_m = 0;  // after this scan, every scan before it counted
  };

  Course();
  const std::vector<Scan>& scans() const { return scans_; }
  const Sensor& sensor() const { return sensor_; }
  /// How many keyframes the recommended rule makes of it: more than may be on their way at a time.
  std::size_t keyframes() const { return keyframes_; }

  /// nullptr: no scan was taken then.
  const Scan* at(double stamp_s) const;

  /// scans/*.bin, poses.txt, sensor.json. Throws std::runtime_error when the disk says no.
  void write(const std::filesystem::path& folder) const;

 private:
  std::vector<Scan> scans_;
  Sensor sensor_{"conformance-24", 24, 22.5F, 22.5F, 60};
  std::size_t keyframes_ = 0;
};

}  // namespace headframe::conformance
