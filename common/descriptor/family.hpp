#pragma once
// The common interface of descriptor families.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/descriptor/circular.hpp"
#include "common/result.hpp"
#include "common/session/keyframe.hpp"

namespace headframe {

/// Computes descriptors of scans, and compares them. All calls are thread safe.
class DescriptorFamily {
 public:
  virtual ~DescriptorFamily() = default;
  virtual FamilyId id() const = 0;
  virtual std::size_t q_size() const = 0;
  virtual std::size_t w_size() const = 0;

  /// points_level: one scan in the levelled sensor frame (origin at the sensor, z along gravity, heading kept), finite.
  /// Fails with bad_input when there are too few points to describe.
  virtual Result<Descriptor> extract(const Points& points_level) const = 0;

  /// One line that says why this scan is unlike those the family was made for; empty if it is not. extract() works
  /// anyway.
  virtual std::string unfamiliar(const Points& /*points_level*/) const { return {}; }

  /// The same for every family (circular.hpp). Empty if the family has no w.
  std::vector<YawScore> yaw_difference(const std::vector<float>& w_a, const std::vector<float>& w_b,
                                       std::size_t most) const {
    return correlate_circular(w_a, w_b, most);
  }
};

/// bad_input if a scan has too few points for any family.
Result<void> enough_points(const Points& points);

/// learned, scan_context, lidar_iris, or onnx:FILE (a network of the user's own, network_family.hpp). not_found:
/// unknown name (the message lists the known ones) or no such file; bad_input: an unusable file. The default is
/// default_family_name.
Result<std::unique_ptr<DescriptorFamily>> make_family(std::string_view name);

inline constexpr std::string_view default_family_name = "learned";

}  // namespace headframe
