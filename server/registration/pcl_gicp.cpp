#include "server/registration/pcl_gicp.hpp"

#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>

namespace headframe {
namespace {

constexpr int neighbours = 20;
constexpr double reach_m = 1;

pcl::PointCloud<pcl::PointXYZ>::Ptr to_pcl(const Points& points) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const auto& p : finite_points(points, 0)) cloud->emplace_back(p.x(), p.y(), p.z());  // PCL aborts on others
  return cloud;
}

}  // namespace

Pose pcl_gicp(const Points& target, const Points& source, const Pose& T_target_source_0) {
  if (!T_target_source_0.matrix().allFinite()) return T_target_source_0;
  const auto of_target = to_pcl(target), of_source = to_pcl(source);
  if (of_target->size() <= neighbours || of_source->size() <= neighbours) return T_target_source_0;
  try {
    pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
    gicp.setCorrespondenceRandomness(neighbours);
    gicp.setMaxCorrespondenceDistance(reach_m);
    gicp.setInputTarget(of_target);
    gicp.setInputSource(of_source);
    pcl::PointCloud<pcl::PointXYZ> aligned;
    gicp.align(aligned, T_target_source_0.matrix().cast<float>());
    Pose T = Pose::Identity();
    T.matrix() = gicp.getFinalTransformation().cast<double>();
    if (T.matrix().allFinite()) return orthonormalised(T);
  } catch (const std::exception&) {  // PCL throws if its optimiser cannot proceed
  }
  return T_target_source_0;
}

}  // namespace headframe
