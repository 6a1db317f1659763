#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// The target of a request line, such as "/api/v1/atlas?wait=5", split and percent-decoded.
struct RequestTarget {
  std::string path;
  std::map<std::string, std::string> query;
};

/// bad_input: it does not begin with '/', has a broken %XX, or has a parameter twice. Pure.
Result<RequestTarget> parse_target(std::string_view target);

/// Reads a finite number in [least, most]. invalid_argument: the message names the parameter and the range.
Result<double> parse_number(std::string_view name, const std::string& text, double least, double most);

}  // namespace headframe
