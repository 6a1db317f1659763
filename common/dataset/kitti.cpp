#include "common/dataset/columns.hpp"
#include "common/dataset/scan_formats.hpp"

namespace headframe::dataset {

Result<ScanTable> parse_kitti(std::string_view bytes) {
  constexpr std::size_t stride = 16;
  if (bytes.size() % stride != 0)
    return failure(ErrorCode::bad_input,
                   "truncated: " + std::to_string(bytes.size()) +
                       " bytes are no multiple of 16 (x y z intensity as float32); the last whole "
                       "point ends at byte " +
                       std::to_string(bytes.size() / stride * stride));
  return points_of_binary(bytes, bytes.size() / stride,
                          {{Column{ScalarKind::real, 4, 0, stride}, Column{ScalarKind::real, 4, 4, stride},
                            Column{ScalarKind::real, 4, 8, stride}},
                           Column{ScalarKind::real, 4, 12, stride}});
}

}  // namespace headframe::dataset
