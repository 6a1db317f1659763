#include "server/operator/routes.hpp"

#include "server/operator/api_json.hpp"
#include "server/operator/changes_json.hpp"
#include "server/operator/explain_request.hpp"
#include "server/operator/overlay.hpp"
#include "server/operator/overview.hpp"
#include "server/operator/point_tiles.hpp"
#include "server/operator/request_target.hpp"
#include "server/operator/trajectory_export.hpp"

namespace headframe::routes {

Result<Reply> status(const Query&, const Context& context) {
  const Station& station = context.station;
  return json(
      status_json(station.sessions(), station.atlas(), station.pending(), station.link_health(), context.uptime_s));
}

Result<Reply> sessions(const Query&, const Context& context) {
  return json(sessions_json(context.station.sessions(), context.station.atlas().atlas));
}

Result<Reply> atlas(const Query& query, const Context& context) {
  const auto wait = query.find("wait");
  if (wait == query.end()) {
    const AtlasView view = context.station.atlas();  // read before the sessions, so that their list has all it names
    return json(atlas_json(view, context.station.sessions(), nullptr));
  }
  const auto timeout_s = parse_number("wait", wait->second, 0, context.limits.wait_s);
  if (!timeout_s) return tl::unexpected(timeout_s.error());
  return Later{[&station = context.station, seconds = *timeout_s](auto answer) {
    station.when_idle(seconds, [&station, answer = std::move(answer)](const Pending& left) {
      const WaitOutcome outcome{left, !left.idle()};
      const AtlasView view = station.atlas();
      answer(json(atlas_json(view, station.sessions(), &outcome)));
    });
  }};
}

Result<Reply> alignments(const Query& query, const Context& context) {
  constexpr double most_rejected = 1000;
  AlignmentChoice choice;
  const auto most = whole_number(query, "most", most_rejected, 1e6);
  if (!most) return tl::unexpected(most.error());
  choice.most_rejected = *most;
  if (query.contains("id")) {
    const auto id = alignment_named(query);
    if (!id) return tl::unexpected(id.error());
    choice.id = *id;
  }
  if (const auto asked = query.find("state"); asked != query.end()) {
    choice.state = alignment_state_from(asked->second);
    if (!choice.state)
      return failure(ErrorCode::invalid_argument, "there is no state \"" + asked->second + "\"" +
                                                      "; there are candidate, provisional, verified, published, "
                                                      "retracted, rejected");
  }
  return json(alignments_json(context.station.atlas(), choice));
}

Result<Reply> changes(const Query& query, const Context& context) {
  constexpr double latest_s = 1e11;
  double since_s = 0;
  if (const auto since = query.find("since"); since != query.end()) {
    const auto given = parse_number("since", since->second, 0, latest_s);
    if (!given) return tl::unexpected(given.error());
    since_s = *given;
  }
  const AtlasView view = context.station.atlas();  // read before the sessions, so that their list has all it names
  return json(changes_json(view, context.station.sessions(), since_s));
}

Result<Reply> explain_pair(const Query& query, const Context& context) {
  const auto a = required(query, "a"), b = required(query, "b");
  if (!a) return tl::unexpected(a.error());
  if (!b) return tl::unexpected(b.error());
  return explain_request(context.station, *a, *b).map([](std::string body) -> Reply { return json(std::move(body)); });
}

/// The tolerance of a thinned path in metres; 0: the whole path is sent.
Result<double> path_tolerance(const Query& query) {
  constexpr double most_m = 1000;
  const auto given = query.find("tolerance");
  return given == query.end() ? 0 : parse_number("tolerance", given->second, 0, most_m);
}

Result<Reply> overview(const Query& query, const Context& context) {
  const auto level = whole_number(query, "level", 1, static_cast<double>(level_cube_m.size() - 1));
  const auto most = whole_number(query, "most", 5000, 1e6);
  for (const auto* number : {&level, &most})
    if (!*number) return tl::unexpected(number->error());
  const auto tolerance_m = path_tolerance(query);
  if (!tolerance_m) return tl::unexpected(tolerance_m.error());
  return Stream{"application/octet-stream",
                std::make_unique<Overview>(context.station, context.tiles, *level, *most, *tolerance_m)};
}

Result<Reply> points(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  const auto level = whole_number(query, "level", 2, static_cast<double>(level_cube_m.size() - 1));
  const auto first = whole_number(query, "from", 0, 1e9), most = whole_number(query, "most", 1e6, 1e7);
  for (const auto* number : {&level, &first, &most})
    if (!*number) return tl::unexpected(number->error());
  return Stream{
      "application/octet-stream",
      std::make_unique<PointStream>(context.tiles.tile(row->id, *level, row->keyframes, row->moves), *first, *most)};
}

Result<Reply> path(const Query& query, const Context& context) {
  const auto row = session_in_path(query, context);
  if (!row) return tl::unexpected(row.error());
  const auto first = whole_number(query, "from", 1, 1e15);
  if (!first) return tl::unexpected(first.error());
  const auto tolerance_m = path_tolerance(query);
  if (!tolerance_m) return tl::unexpected(tolerance_m.error());
  return Stream{"application/json", std::make_unique<PathJson>(context.station, row->id, *first, *tolerance_m)};
}

Result<Reply> overlay(const Query& query, const Context& context) {
  const auto id = alignment_named(query);
  if (!id) return tl::unexpected(id.error());
  const auto most = whole_number(query, "most", 10000, 1e5);
  if (!most) return tl::unexpected(most.error());
  for (AlignmentRow& row : context.station.atlas().alignments) {
    if (row.alignment.id != *id) continue;
    if (!has_placement(row.alignment))
      return failure(ErrorCode::not_found, "nothing fitted in alignment " + std::to_string(*id) +
                                               ": there is no placement to show; explain says why");
    return Stream{"application/json", std::make_unique<OverlayJson>(context.station, row.alignment, *most)};
  }
  return failure(ErrorCode::not_found,
                 "there is no alignment " + std::to_string(*id) + "; the list of alignments has those there are");
}

}  // namespace headframe::routes
