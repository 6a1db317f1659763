#pragma once

#include <memory>
#include <vector>

#include "server/verification/submap.hpp"
#include "tests/support/box_mine.hpp"

namespace headframe::test {

/// A drive's clouds, prepared, at its poses; numbered from 1.
inline std::vector<PlacedCloud> placed(const Drive& drive) {
  std::vector<PlacedCloud> out;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i)
    out.push_back(
        {i + 1, drive.keyframes[i].T_local_sensor, std::make_shared<PreparedCloud>(prepare(drive.clouds[i]))});
  return out;
}

}  // namespace headframe::test
