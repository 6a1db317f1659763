#include "common/descriptor/network_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace headframe {
namespace {

using nlohmann::json;

tl::unexpected<Error> bad(const std::string& name, const std::string& what) {
  return failure(ErrorCode::bad_input,
                 name + ": " + what + "; it looks like this: " + std::string(network_image_example));
}

struct Number {
  std::string_view key;
  double low, high, value = 0;
  bool whole = false;
};

Result<void> take(const json& object, Number& n, const std::string& name) {
  const json& value = object.at(std::string(n.key));
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= n.low && number <= n.high) || (n.whole && number != std::floor(number)))
    return bad(name, std::string(n.key) + " must be a " + (n.whole ? "whole number" : "number") + " from " +
                         json(n.low).dump() + " to " + json(n.high).dump());
  n.value = number;
  return {};
}

Result<NetworkImage> read(const json& object, const std::string& name) {
  std::array<Number, 4> numbers{Number{"rows", 1, 1024, 0, true}, Number{"columns", 64, 8192, 0, true},
                                Number{"fov_up_deg", -90, 90}, Number{"fov_down_deg", -90, 90}};
  std::vector<std::string> keys{"encoding"};
  keys.reserve(numbers.size() + 1);
  for (const Number& n : numbers) keys.emplace_back(n.key);
  if (!object.is_object()) return bad(name, "no JSON object");
  for (const auto& [key, value] : object.items())
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) return bad(name, "unknown key " + key);
  for (const std::string& key : keys)
    if (!object.contains(key)) return bad(name, key + " is missing");
  for (Number& n : numbers)
    if (auto ok = take(object, n, name); !ok) return tl::unexpected(ok.error());
  NetworkImage image;
  image.spec = {static_cast<std::size_t>(numbers[0].value), static_cast<std::size_t>(numbers[1].value),
                numbers[2].value, -numbers[3].value};
  if (image.spec.top_deg <= image.spec.bottom_deg)
    return bad(name, "fov_up_deg and fov_down_deg leave nothing between");
  if (object["encoding"] == "log_range_mask") return image;
  image.encoding = ImageEncoding::range_m;
  if (object["encoding"] == "range_m") return image;
  return bad(name, "encoding must be log_range_mask or range_m");
}

}  // namespace

Network::Shape NetworkImage::shape() const {
  return {encoding == ImageEncoding::log_range_mask ? 2U : 1U, spec.rows, spec.columns};
}

RangeImage NetworkImage::draw(const Points& points_level) const {
  RangeImage image = range_image(points_level, spec);
  if (encoding == ImageEncoding::log_range_mask) fill_small_holes(image, 2, 4);
  return image;
}

std::vector<float> NetworkImage::encode(const RangeImage& image) const {
  return encoding == ImageEncoding::log_range_mask ? log_range_and_mask(image) : image.range_m;
}

Result<NetworkImage> parse_network_image(std::string_view json_text, const std::string& name) {
  try {
    return read(json::parse(json_text), name);
  } catch (const json::parse_error& e) {
    return bad(name, "no JSON, at byte " + std::to_string(e.byte));
  } catch (const json::exception& e) {  // text that is not UTF-8, numbers beyond a double
    return bad(name, e.what());
  }
}

}  // namespace headframe
