#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <vector>

#include "server/operator/body_source.hpp"
#include "server/operator/placed_component.hpp"

namespace headframe {

enum class CloudFormat { ply, pcd, las };

struct ExportRequest {
  SessionId component = 0;
  CloudFormat format = CloudFormat::ply;
  double voxel_m = 0.1;  // one point per cube of this size, for each keyframe separately; 0: every point
  OutputFrame frame = OutputFrame::component;
};

/// The stored clouds of one component as binary little-endian PLY or PCD, or as LAS, in metres, coloured by robot. LAS
/// also gives the session and the time of each point. Intensity ranges from 0 to 255 (in LAS to 65535), and is 0 where
/// a robot gave none; PLY and PCD have no intensity column if no robot gave any. A thinned point has the mean of the
/// points in its cube. Coordinates in the grid, and those of a component more than 10 km from its origin, are doubles
/// in PLY, and relative to an offset in PCD (given in a comment); LAS always has an offset, in its header. All formats
/// begin with the number of points, so a first pass counts and a second one writes; only one keyframe's cloud is in
/// memory at a time. A cloud that is stored after its keyframe was counted is left out.
class MapExport : public BodySource {
 public:
  MapExport(const Station& station, ExportRequest request) : station_(station), request_(request) {}

  /// Handles one keyframe per call. not_found: no such component, or no survey for the grid; internal: a cloud changed
  /// between the passes.
  Result<std::optional<std::string>> next() override;
  std::optional<std::uint64_t> total_bytes() const override { return total_bytes_; }

 private:
  enum class Stage { start, count, write };
  using Colour = std::array<std::uint8_t, 3>;
  struct Item {
    SessionId session = 0;
    std::uint64_t sequence = 0;
    Pose T_frame_sensor = Pose::Identity();
    Colour colour{};
    std::size_t points = 0;
    std::uint16_t source = 0;  // its session's index in the component, from 1
    double stamp_s = 0;
  };

  Result<void> list_keyframes();
  Result<void> count(Item& item);
  Result<std::string> written(const Item& item) const;
  Result<Returns> thinned(const Item& item) const;
  void append_point(std::string& out, const Eigen::Vector3d& p_frame, std::uint8_t intensity, const Item& item) const;
  bool wide() const;
  std::size_t point_bytes() const;
  std::string header();
  std::string las(std::size_t points) const;
  std::string text_header(std::size_t points) const;

  const Station& station_;
  ExportRequest request_;
  Stage stage_ = Stage::start;
  std::vector<Item> items_;
  std::vector<std::string> legend_;  // one line for each robot
  std::size_t at_ = 0;
  bool has_wall_clock_ = false;  // all stamps are seconds since 1970
  bool has_intensity_ = false;   // at least one point has one
  Eigen::AlignedBox3d box_m_;    // bounds of all points, only for LAS
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  std::optional<std::uint64_t> total_bytes_;  // known once the header is made
};

}  // namespace headframe
