#pragma once
// As much of JSON Schema as our OpenAPI file uses, to hold answers against it.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace headframe {

class JsonSchema {
 public:
  /// `document` is what "$ref" points into.
  explicit JsonSchema(nlohmann::json document) : document_(std::move(document)) {}

  /// What of the value is not as the schema says, a line each; empty: it fits.
  std::vector<std::string> faults(const nlohmann::json& value, const nlohmann::json& schema) const {
    std::vector<std::string> out;
    check(value, schema, "answer", out);
    return out;
  }

 private:
  using Json = nlohmann::json;
  using Faults = std::vector<std::string>;

  void check(const Json& value, const Json& schema, const std::string& where, Faults& out) const {
    if (schema.contains("$ref"))
      return check(value, document_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))), where, out);
    if (value.is_null() && schema.value("nullable", false)) return;
    for (const Json& part : schema.value("allOf", Json::array())) check(value, part, where, out);
    if (!schema.contains("type")) return;
    if (!is(value, schema["type"])) {
      out.push_back(where + " is " + value.dump() + ", no " + schema["type"].get<std::string>());
      return;
    }
    if (schema.contains("enum") &&
        std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
      out.push_back(where + " is " + value.dump());
    if (value.is_number() && schema.contains("minimum") && value < schema["minimum"])
      out.push_back(where + " is " + value.dump());
    if (value.is_object()) check_object(value, schema, where, out);
    if (value.is_array()) check_array(value, schema, where, out);
  }

  void check_object(const Json& value, const Json& schema, const std::string& where, Faults& out) const {
    for (const Json& name : schema.value("required", Json::array()))
      if (!value.contains(name.get<std::string>())) out.push_back(where + " lacks " + name.get<std::string>());
    const Json properties = schema.value("properties", Json::object());
    const Json others = schema.value("additionalProperties", Json(true));
    for (const auto& [name, member] : value.items()) {
      std::string path = where;
      path.append(".").append(name);
      if (properties.contains(name)) {
        check(member, properties[name], path, out);
      } else if (others.is_object()) {
        check(member, others, path, out);
      } else if (others == false) {
        out.push_back(path + " is not described");
      }
    }
  }

  void check_array(const Json& value, const Json& schema, const std::string& where, Faults& out) const {
    const std::size_t size = value.size();
    if (size < schema.value("minItems", std::size_t{0}) || size > schema.value("maxItems", size))
      out.push_back(where + " has " + std::to_string(size) + " items");
    for (std::size_t i = 0; i < size; ++i) check(value[i], schema["items"], where + "[" + std::to_string(i) + "]", out);
  }

  static bool is(const Json& value, const std::string& type) {
    return type == "object"    ? value.is_object()
           : type == "array"   ? value.is_array()
           : type == "string"  ? value.is_string()
           : type == "boolean" ? value.is_boolean()
           : type == "integer" ? value.is_number_integer()
           : type == "number"  ? value.is_number()
                               : false;
  }

  Json document_;
};

}  // namespace headframe
