#pragma once

namespace headframe {

/// The method that registers one submap on another.
enum class RegistrationEngine {
  vgicp,     // our own voxelized GICP
  pcl_gicp,  // PCL's Generalized-ICP: some twenty times slower, for comparison
};

}  // namespace headframe
