#include "common/dataset/sensor_file.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/dataset/text.hpp"

namespace headframe::dataset {
namespace {

using nlohmann::json;

struct Range {
  double low, high;
};

// Reads the key into value, which keeps its default, with a warning, when the key is missing.
Result<void> read_number(const json& object, const std::string& key, Range range, float& value,
                         std::vector<std::string>& warnings) {
  const auto found = object.find(key);
  if (found == object.end()) {
    warnings.push_back("no '" + key + "', taken as " + json(value).dump());
    return {};
  }
  if (!found->is_number()) return bad("'" + key + "' is not a number");
  const auto number = found->get<double>();
  if (!(number >= range.low && number <= range.high))
    return bad("'" + key + "' is " + found->dump() + ", must be " + json(range.low).dump() + " to " +
               json(range.high).dump());
  value = static_cast<float>(number);
  return {};
}

Result<void> read_model(const json& object, std::string& model, std::vector<std::string>& warnings) {
  const auto found = object.find("model");
  if (found == object.end()) {
    warnings.push_back("no 'model', taken as '" + model + "'");
    return {};
  }
  if (!found->is_string()) return bad("'model' is not a string");
  model = found->get<std::string>();
  if (model.size() > 100) return bad("'model' is longer than 100 bytes");
  return {};
}

Result<SensorFile> read_sensor(const json& object) {
  if (!object.is_object()) return bad("not a JSON object");
  SensorFile file{default_sensor(), {}};
  Sensor& sensor = file.sensor;
  auto beams = static_cast<float>(sensor.beams);
  Result<void> done = read_model(object, sensor.model, file.warnings);
  if (done) done = read_number(object, "beams", {1, 1024}, beams, file.warnings);
  if (done) done = read_number(object, "fov_up_deg", {0, 90}, sensor.fov_up_deg, file.warnings);
  if (done) done = read_number(object, "fov_down_deg", {-90, 90}, sensor.fov_down_deg, file.warnings);
  if (done) done = read_number(object, "max_range_m", {0.1, 10000}, sensor.max_range_m, file.warnings);
  if (!done) return tl::unexpected(done.error());
  if (beams != std::floor(beams)) return bad("'beams' is not a whole number");
  sensor.beams = static_cast<int>(beams);
  sensor.fov_down_deg = std::abs(sensor.fov_down_deg);
  return file;
}

}  // namespace

Sensor default_sensor() { return {"unknown", 32, 22.5F, 22.5F, 100.0F}; }

Result<SensorFile> parse_sensor(std::string_view json_text) {
  try {
    return read_sensor(json::parse(json_text));
  } catch (const json::parse_error& e) {
    return bad("not JSON, at byte " + std::to_string(e.byte));
  } catch (const json::exception& e) {  // dump() of text that is not UTF-8, numbers beyond a double
    return bad(e.what());
  }
}

}  // namespace headframe::dataset
