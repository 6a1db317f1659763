#pragma once

#include "client/localization.hpp"
#include "common/result.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// Converts the base station's answer; bad_input if a name, a pose or a number is invalid. Pure, thread safe.
Result<Localization> localization_from(const v1::Localization& message);

}  // namespace headframe
