#include "tests/bench/pcl_gicp.hpp"

#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>

namespace headframe::bench {
namespace {

pcl::PointCloud<pcl::PointXYZ>::Ptr to_pcl(const Points& points) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const auto& p : points) cloud->emplace_back(p.x(), p.y(), p.z());
  return cloud;
}

}  // namespace

Pose pcl_gicp(const Points& target, const Points& source) {
  pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> gicp;
  gicp.setCorrespondenceRandomness(20);
  gicp.setMaxCorrespondenceDistance(1.0);
  gicp.setInputTarget(to_pcl(target));
  gicp.setInputSource(to_pcl(source));
  pcl::PointCloud<pcl::PointXYZ> aligned;
  gicp.align(aligned);
  Pose T = Pose::Identity();
  T.matrix() = gicp.getFinalTransformation().cast<double>();
  return orthonormalised(T);
}

}  // namespace headframe::bench
