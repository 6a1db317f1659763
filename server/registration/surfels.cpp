#include "server/registration/surfels.hpp"

#include <Eigen/Eigenvalues>

#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr std::size_t fewest_neighbours = 6;
constexpr float flattest_line = 0.02F;  // middle / largest eigenvalue below this: a line, whose normal is arbitrary

bool plane_normal(const Points& points, const std::vector<Neighbour>& around, Eigen::Vector3f& normal) {
  if (around.size() < fewest_neighbours) return false;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const Neighbour& n : around) mean += points[n.index];
  mean /= static_cast<float>(around.size());
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (const Neighbour& n : around) {
    const Eigen::Vector3f d = points[n.index] - mean;
    scatter += d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
  eigen.computeDirect(scatter);
  const auto& values = eigen.eigenvalues();
  if (!(values[1] > flattest_line * values[2])) return false;
  normal = eigen.eigenvectors().col(0);
  return normal.allFinite();
}

}  // namespace

Surfels make_surfels(const Points& points, std::size_t neighbours, int threads) {
  const KdTree tree(points);
  Points normals(points.size(), Eigen::Vector3f::Zero());
  for_blocks(points.size(), 256, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    std::vector<Neighbour> around;
    for (std::size_t i = begin; i < end; ++i) {
      tree.nearest_k(points[i], neighbours, around);
      if (!plane_normal(points, around, normals[i])) normals[i].setZero();
    }
  });
  Surfels out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (normals[i].isZero()) continue;
    out.points.push_back(points[i]);
    out.normals.push_back(normals[i]);
  }
  out.tree = KdTree(out.points);
  return out;
}

}  // namespace headframe
