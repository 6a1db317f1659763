#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "headframe/v1/robot.pb.h"

namespace headframe {

/// One update of a component's transforms as serialised ServerMessages, in the order in which they are sent.
using TransformPages = std::vector<std::string>;

/// The update as one message while that is no longer than page_bytes; beyond, its sessions on pages of about as many
/// bytes, and what is provisional or withdrawn on the last.
TransformPages transform_pages(const v1::TransformUpdate& update, std::size_t page_bytes);

}  // namespace headframe
