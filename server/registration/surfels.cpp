#include "server/registration/surfels.hpp"

#include <Eigen/Eigenvalues>

#include "server/registration/neighbourhood.hpp"
#include "server/support/parallel.hpp"

namespace headframe {
namespace {

constexpr float fewest_neighbours = 6;
constexpr float flattest_line = 0.02F;  // middle / largest eigenvalue; a line has less, and an arbitrary normal
constexpr std::size_t block_leaves = 16;

bool plane_normal(const Neighbourhood& around, Eigen::Vector3f& normal) {
  if (around.count < fewest_neighbours) return false;
  const auto& [xx, xy, xz, yy, yz, zz] = around.scatter;
  Eigen::Matrix3f scatter;
  scatter << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen;
  eigen.computeDirect(scatter);
  const auto& values = eigen.eigenvalues();
  if (!(values[1] > flattest_line * values[2])) return false;
  normal = eigen.eigenvectors().col(0);
  return normal.allFinite();
}

}  // namespace

Surfels make_surfels(const Points& points, std::size_t neighbours, int threads) {
  Surfels out;
  out.tree = KdTree(points, threads);
  const auto& leaves = out.tree.leaves();
  Points normals(leaves.size() * KdTree::leaf_points, Eigen::Vector3f::Zero());
  for_blocks(leaves.size(), block_leaves, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    NeighbourhoodFinder finder(out.tree, neighbours);
    for (std::size_t leaf = begin; leaf < end; ++leaf) {
      const auto around = finder.find(leaf);
      for (std::size_t i = 0; i < around.size(); ++i) {
        Eigen::Vector3f& normal = normals[leaf * KdTree::leaf_points + i];
        if (!plane_normal(around[i], normal)) normal.setZero();
      }
    }
  });
  out.points.reserve(points.size());
  out.normals.reserve(points.size());
  std::vector<std::uint32_t> new_index(points.size(), KdTree::nobody);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (normals[i].isZero()) continue;
    const std::uint32_t index = leaves[i / KdTree::leaf_points].index[i % KdTree::leaf_points];
    new_index[index] = static_cast<std::uint32_t>(out.points.size());
    out.points.push_back(points[index]);
    out.normals.push_back(normals[i]);
  }
  out.tree.renumber(new_index);
  return out;
}

}  // namespace headframe
