// An operator places one session on another, roughly.
#include <nlohmann/json.hpp>
#include <numbers>

#include "server/atlas/rough_placement.hpp"
#include "server/operator/api_json.hpp"
#include "server/operator/explain_request.hpp"
#include "server/operator/routes.hpp"

namespace headframe::routes {
namespace {

using Json = nlohmann::json;

tl::unexpected<Error> broken() {
  return failure(
      ErrorCode::invalid_argument,
      "the placement of b on a: give {\"at\": [x, y, z, yaw_deg]}, b's origin in a, or {\"pairs\": [{\"p_a\": "
      "[x, y, z], \"p_b\": [x, y, z]}, ...], three or more");
}

/// Empty if the value is not a list of `count` numbers.
std::vector<double> numbers(const Json& object, const char* name, std::size_t count) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array() || found->size() != count) return {};
  std::vector<double> out;
  for (const Json& number : *found)
    if (number.is_number()) out.push_back(number.get<double>());
  return out.size() == count ? out : std::vector<double>();
}

Result<Pose> placement_in(std::string_view body) {
  constexpr std::size_t most_pairs = 1000;
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object() || json.contains("at") == json.contains("pairs")) return broken();
  if (json.contains("at")) {
    const auto at = numbers(json, "at", 4);
    return at.empty() ? broken() : rough_placement({at[0], at[1], at[2]}, at[3]);
  }
  const Json& rows = json["pairs"];
  if (!rows.is_array() || rows.size() > most_pairs) return broken();
  std::vector<PointPair> pairs;
  for (const Json& row : rows) {
    if (!row.is_object()) return broken();
    const auto a = numbers(row, "p_a", 3), b = numbers(row, "p_b", 3);
    if (a.empty() || b.empty()) return broken();
    pairs.push_back({Eigen::Vector3d(a.data()), Eigen::Vector3d(b.data())});
  }
  return rough_placement(pairs);
}

/// If the registration failed, moved_m and turned_deg are null.
std::string answer_of(const HandPlacement& placed, const std::string& explanation) {
  constexpr double deg = 180 / std::numbers::pi;
  const bool registered = has_placement(placed.alignment);
  return Json{{"recorded", placed.recorded},
              {"moved_m", registered ? Json(placed.moved_m) : Json()},
              {"turned_deg", registered ? Json(placed.turned_rad * deg) : Json()},
              {"explanation", Json::parse(explanation)}}
             .dump() +
         "\n";
}

}  // namespace

/// POST /api/v1/place?a=A&b=B
Result<Reply> place(const Query& query, const Context& context) {
  const auto a = required(query, "a"), b = required(query, "b");
  if (!a) return tl::unexpected(a.error());
  if (!b) return tl::unexpected(b.error());
  const auto rows = context.station.sessions();
  const auto of_a = find_session(rows, *a), of_b = find_session(rows, *b);
  if (!of_a) return tl::unexpected(of_a.error());
  if (!of_b) return tl::unexpected(of_b.error());
  if (of_a->id == of_b->id)
    return failure(ErrorCode::invalid_argument, "\"" + *a + "\" and \"" + *b + "\" are the same session");
  const auto T_a_b = placement_in(context.body);
  if (!T_a_b) return tl::unexpected(T_a_b.error());
  return Later{[&station = context.station, a = *of_a, b = *of_b, T_a_b = *T_a_b](auto answer) {
    station.place(a.id, b.id, T_a_b, [&station, a, b, answer = std::move(answer)](const Result<HandPlacement>& placed) {
      answer(placed ? json(answer_of(*placed, explain_placement(station, a, b, placed->alignment)))
                    : error_reply(placed.error()));
    });
  }};
}

}  // namespace headframe::routes
