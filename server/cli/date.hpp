#pragma once

#include <optional>
#include <string>

namespace headframe {

/// Seconds since 1970 of the beginning of a day given as YYYY-MM-DD, in UTC; nothing for another text.
std::optional<double> seconds_of(const std::string& date);

/// The minute as YYYY-MM-DD hh:mm, in UTC.
std::string date_of(double seconds);

}  // namespace headframe
