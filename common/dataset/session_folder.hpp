#pragma once
// A recorded session on disk: DIR/scans/*.bin|pcd|ply, DIR/poses.txt (TUM, sensor poses in the session's own frame) and
// DIR/sensor.json. Scan k belongs to pose k; scans are sorted by name, with numbers compared by value (2 before 10).

#include <filesystem>
#include <string>
#include <vector>

#include "common/dataset/poses_file.hpp"
#include "common/dataset/scan_file.hpp"
#include "common/result.hpp"
#include "common/session/keyframe.hpp"

namespace headframe {

/// Poses and file names are held in memory; scans are read one at a time. After open() all calls are const and thread
/// safe.
class SessionFolder {
 public:
  /// Fails with not_found (no folder, no scans folder, no poses.txt), bad_input (invalid poses.txt or sensor.json, no
  /// poses, or another number of poses than of scans) or unavailable; the message names the file and the line. Does not
  /// open scans.
  static Result<SessionFolder> open(const std::filesystem::path& path);

  const Sensor& sensor() const { return sensor_; }
  /// Things that are unusual but not wrong, one line each: no sensor.json, missing keys in it, other files among the
  /// scans.
  const std::vector<std::string>& warnings() const { return warnings_; }

  std::size_t size() const { return poses_.size(); }
  double stamp_s(std::size_t i) const { return poses_.at(i).stamp_s; }
  const Pose& T_local_sensor(std::size_t i) const { return poses_.at(i).T_local_sensor; }

  using Scan = headframe::Scan;
  /// Scan i < size(), in the sensor frame. Fails as load_scan does.
  Result<Scan> load(std::size_t i) const { return load_scan(scans_.at(i)); }

 private:
  Result<void> find_scans(const std::filesystem::path& folder);
  Result<void> read_poses(const std::filesystem::path& file);
  Result<void> read_sensor(const std::filesystem::path& file);

  Sensor sensor_;
  std::vector<dataset::StampedPose> poses_;
  std::vector<std::filesystem::path> scans_;
  std::vector<std::string> warnings_;
};

}  // namespace headframe
