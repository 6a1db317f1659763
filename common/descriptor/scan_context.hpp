#pragma once

#include "common/descriptor/family.hpp"

namespace headframe {

/// Scan Context (Kim and Kim, IROS 2018) reduced to what travels: 20 rings x 60 sectors up to 40 m, each cell the
/// height of its highest and lowest point. q is the ring key, widened: per ring the mean and spread of the heights and
/// the share of sectors seen (independent of yaw). w is the sector key: the mean over rings of every sector (shifts
/// with yaw). Deviation: rings grow with the distance, since tunnels are 3 to 10 m wide; heights are floor to roof,
/// since a mine has both.
class ScanContext : public DescriptorFamily {
 public:
  FamilyId id() const override { return {"scan_context", 1}; }
  std::size_t q_size() const override { return 60; }
  std::size_t w_size() const override { return 60; }
  Result<Descriptor> extract(const Points& points_level) const override;
};

}  // namespace headframe
