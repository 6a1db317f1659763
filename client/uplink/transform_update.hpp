#pragma once

#include "client/transforms.hpp"
#include "common/result.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// Converts what the base station sent of a component; bad_input if a name, a pose or a number is invalid. Pure, thread
/// safe.
Result<Transforms> transforms_from(const v1::TransformUpdate& message);

}  // namespace headframe
