#include "server/operator/request_target.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

namespace headframe {
namespace {

std::optional<std::string> percent_decoded(std::string_view text, bool plus_is_space) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && plus_is_space) {
      out += ' ';
    } else if (text[i] != '%') {
      out += text[i];
    } else {
      unsigned value = 0;
      if (i + 2 >= text.size()) return std::nullopt;
      const char* end = text.data() + i + 3;
      if (std::from_chars(text.data() + i + 1, end, value, 16).ptr != end) return std::nullopt;
      out += static_cast<char>(value);
      i += 2;
    }
  }
  return out;
}

tl::unexpected<Error> broken(std::string_view target) {
  return failure(ErrorCode::bad_input, "the request target \"" + std::string(target.substr(0, 200)) +
                                           "\" is not /path?name=value with %XX for special characters");
}

}  // namespace

Result<RequestTarget> parse_target(std::string_view target) {
  if (target.empty() || target.front() != '/') return broken(target);
  const std::size_t mark = target.find('?');
  const auto path = percent_decoded(target.substr(0, mark), false);
  if (!path) return broken(target);
  RequestTarget out{*path, {}};
  std::string_view rest = mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    if (pair.empty()) continue;
    const std::size_t equals = pair.find('=');
    const auto name = percent_decoded(pair.substr(0, equals), true);
    const auto value = percent_decoded(equals == std::string_view::npos ? "" : pair.substr(equals + 1), true);
    if (!name || !value) return broken(target);
    if (!out.query.emplace(*name, *value).second)
      return failure(ErrorCode::bad_input, "parameter \"" + *name + "\" is given twice; give it once");
  }
  return out;
}

Result<double> parse_number(std::string_view name, const std::string& text, double least, double most) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (whole && value >= least && value <= most) return value;  // false for NaN
  std::ostringstream message;
  message << "parameter \"" << name << "\" is \"" << text << "\"; give a number from " << least << " to " << most;
  return failure(ErrorCode::invalid_argument, message.str());
}

}  // namespace headframe
