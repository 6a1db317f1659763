#include "server/cli/date.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace headframe {

std::optional<double> seconds_of(const std::string& date) {
  int year = 0;
  unsigned month = 0, day = 0;
  char more = 0;
  if (date.size() != 10 || std::sscanf(date.c_str(), "%4d-%2u-%2u%c", &year, &month, &day, &more) != 3)
    return std::nullopt;
  const std::chrono::year_month_day when{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
  if (!when.ok() || year < 1970) return std::nullopt;
  return std::chrono::duration<double>(std::chrono::sys_days(when).time_since_epoch()).count();
}

std::string date_of(double seconds) {
  using namespace std::chrono;
  constexpr double latest_s = 2.5e11;  // the year 9892
  if (!(seconds >= 0 && seconds < latest_s)) return "?";
  const auto minutes_since = static_cast<std::int64_t>(std::floor(seconds / 60));
  const sys_days day{days(minutes_since / 1440)};
  const year_month_day when(day);
  const auto of_day = minutes_since % 1440;
  std::array<char, 40> out{};
  (void)std::snprintf(out.data(), out.size(), "%04d-%02u-%02u %02d:%02d", static_cast<int>(when.year()),
                      static_cast<unsigned>(when.month()), static_cast<unsigned>(when.day()),
                      static_cast<int>(of_day / 60), static_cast<int>(of_day % 60));
  return out.data();
}

}  // namespace headframe
