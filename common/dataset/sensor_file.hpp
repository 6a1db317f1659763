#pragma once
// sensor.json: model, beams, fov_up_deg, fov_down_deg, max_range_m.

#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe.hpp"

namespace headframe::dataset {

/// Used for a sensor that is not described.
Sensor default_sensor();

struct SensorFile {
  Sensor sensor;
  std::vector<std::string> warnings;  // one for each missing key, whose value was taken from default_sensor()
};

/// Recordings contain fov_down_deg with either sign; its magnitude is used. Other keys are ignored. bad_input: the text
/// is not a JSON object (the message gives the byte), or a value has the wrong type or is out of range. Pure.
Result<SensorFile> parse_sensor(std::string_view json_text);

}  // namespace headframe::dataset
