#pragma once

#include "common/descriptor/family.hpp"

namespace headframe {

/// Scan Context (Kim and Kim, IROS 2018), reduced to what is sent: 20 rings x 60 sectors up to 40 m, each cell with the
/// heights of its highest and lowest point. q is an extended ring key: for each ring the mean and spread of the heights
/// and the share of sectors seen (independent of yaw). w is the sector key: for each sector the mean over the rings
/// (shifts with yaw). Deviations: rings get wider with distance, because tunnels are 3 to 10 m wide; heights are from
/// floor to roof, because a mine has both.
class ScanContext : public DescriptorFamily {
 public:
  FamilyId id() const override { return {"scan_context", 1}; }
  std::size_t q_size() const override { return 60; }
  std::size_t w_size() const override { return 60; }
  Result<Descriptor> extract(const Points& points_level) const override;
};

}  // namespace headframe
