#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// What a request line asks for: "/api/v1/atlas?wait=5", taken apart and percent-decoded.
struct RequestTarget {
  std::string path;
  std::map<std::string, std::string> query;
};

/// bad_input: not starting with '/', a broken %XX, or a parameter given twice. Pure.
Result<RequestTarget> parse_target(std::string_view target);

/// A finite number in [least, most]; invalid_argument names the parameter and the range.
Result<double> parse_number(std::string_view name, const std::string& text, double least, double most);

}  // namespace headframe
