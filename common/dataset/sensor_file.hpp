#pragma once
// sensor.json: model, beams, fov_up_deg, fov_down_deg, max_range_m.

#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/session/keyframe.hpp"

namespace headframe::dataset {

/// What is taken for a sensor of which nothing is told.
Sensor default_sensor();

struct SensorFile {
  Sensor sensor;
  std::vector<std::string> warnings;  // one for each key that is missing and was taken from default_sensor()
};

/// fov_down_deg appears with either sign in recordings: its magnitude counts. Other keys are passed over. Fails with
/// bad_input when the text is not a JSON object (says the byte), or a value has the wrong type or is out of range.
/// Pure.
Result<SensorFile> parse_sensor(std::string_view json_text);

}  // namespace headframe::dataset
