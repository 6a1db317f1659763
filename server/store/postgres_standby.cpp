#include "server/store/postgres_standby.hpp"

#include "server/store/postgres_presence.hpp"
#include "server/store/postgres_schema.hpp"
#include "server/store/postgres_writer.hpp"

namespace headframe {
namespace {

constexpr std::chrono::milliseconds look_for_turn(200);
// Longer than the longest pause after which the active server looks for its database.
constexpr std::chrono::milliseconds active_comes_back(3000);

tl::unexpected<Error> ended() { return failure(ErrorCode::refused, "it was ended while it stood by"); }

}  // namespace

Result<void> PostgresStandby::take(PostgresDatabase& database) {
  const Error back{ErrorCode::unavailable, database.name() + " is back; the server that had it goes first"};
  if (waits_ && !plan_.wait(back, active_comes_back)) return ended();
  for (std::optional<Error> in_use_by_another;;) {
    const auto taken = try_to_take(database);
    if (!taken) return tl::unexpected(taken.error());
    if (*taken) return {};
    if (!waits_)
      if (auto may = begin(database); !may) return may;
    if (!in_use_by_another) in_use_by_another = {ErrorCode::refused, in_use(database)};
    if (!plan_.wait(*in_use_by_another, look_for_turn)) return ended();
  }
}

/// What would only be found out in the emergency is found out now.
Result<void> PostgresStandby::begin(PostgresDatabase& database) {
  if (auto known = schema_is_known(database); !known) return known;
  if (auto may = plan_.may_wait(active_server(database)); !may) return may;
  waits_ = true;
  return {};
}

}  // namespace headframe
