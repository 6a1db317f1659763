#pragma once

#include "client/localization.hpp"
#include "common/result.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// The base station's answer; bad_input where a name, a pose or a number is none. Pure, thread safe.
Result<Localization> localization_from(const v1::Localization& message);

}  // namespace headframe
