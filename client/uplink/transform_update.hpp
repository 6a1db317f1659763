#pragma once

#include "client/transforms.hpp"
#include "common/result.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// What the base station told of a component; bad_input where a name, a pose or a number is none. Pure, thread safe.
Result<Transforms> transforms_from(const v1::TransformUpdate& message);

}  // namespace headframe
