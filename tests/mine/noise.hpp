#pragma once
// Smooth random fields in space, for rock that is rough at several scales.

#include <Eigen/Core>
#include <cstdint>

namespace headframe::mine {

/// Value noise in [-1, 1] with features of about scale_m; smooth, the same for the same seed. Thread safe.
double noise_at(const Eigen::Vector3d& p, double scale_m, std::uint64_t seed);

}  // namespace headframe::mine
