#include "server/operator/routes.hpp"
#include "server/operator/survey_json.hpp"

namespace headframe::routes {
namespace {

Result<SessionRow> session_in_query(const Query& query, const Context& context) {
  const auto id = required(query, "session");
  if (!id) return tl::unexpected(id.error());
  return session_with(*id, context);
}

}  // namespace

Result<Reply> surveys(const Query&, const Context& context) { return json(surveys_json(context.station)); }

Result<Reply> set_survey(const Query& query, const Context& context) {
  const auto row = session_in_query(query, context);
  if (!row) return tl::unexpected(row.error());
  const auto accept = query.find("accept");
  if (accept != query.end() && accept->second != "true" && accept->second != "false")
    return failure(ErrorCode::invalid_argument,
                   "parameter \"accept\" is \"" + accept->second + "\"; give true or false");
  auto survey = survey_from_json(context.body, row->id, accept != query.end() && accept->second == "true");
  if (!survey) return tl::unexpected(survey.error());
  return Later{[&station = context.station, survey = std::move(*survey)](auto answer) {
    station.set_survey(survey, [&station, survey, answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json(survey_json(survey, station)) : error_reply(done.error()));
    });
  }};
}

Result<Reply> drop_survey(const Query& query, const Context& context) {
  const auto row = session_in_query(query, context);
  if (!row) return tl::unexpected(row.error());
  return Later{[&station = context.station, id = row->id](auto answer) {
    station.drop_survey(id, [answer = std::move(answer)](const Result<void>& done) {
      answer(done ? json("{\"dropped\":true}\n") : error_reply(done.error()));
    });
  }};
}

}  // namespace headframe::routes
