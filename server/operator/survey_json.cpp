#include "server/operator/survey_json.hpp"

#include <algorithm>

#include "server/atlas/survey_check.hpp"
#include "server/operator/api_json.hpp"
#include "server/operator/json_text.hpp"

namespace headframe {
namespace {

constexpr std::size_t name_bytes = 128;

tl::unexpected<Error> broken(const std::string& what) {
  return failure(ErrorCode::bad_input, "the survey: " + what +
                                           "; give {\"T_grid_session\": [16 numbers, row-major]} or {\"points\": "
                                           "[{\"name\": .., \"p_session\": [x, y, z], \"p_grid\": [x, y, z]}, ...]}");
}

template <std::size_t Count>
std::optional<std::array<double, Count>> numbers(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array() || found->size() != Count) return std::nullopt;
  std::array<double, Count> out{};
  for (std::size_t i = 0; i < Count; ++i) {
    if (!(*found)[i].is_number()) return std::nullopt;
    out.at(i) = (*found)[i].get<double>();
  }
  return out;
}

Result<ControlPoint> control_point(const Json& row, std::size_t number) {
  const std::string which = "point " + std::to_string(number);
  if (!row.is_object()) return broken(which + " is no object");
  const auto p_session = numbers<3>(row, "p_session"), p_grid = numbers<3>(row, "p_grid");
  if (!p_session || !p_grid) return broken(which + " needs p_session and p_grid of three numbers");
  const auto name = row.find("name");
  if (name != row.end() && (!name->is_string() || name->get_ref<const std::string&>().size() > name_bytes))
    return broken(which + " has a name that is no string of at most " + std::to_string(name_bytes) + " bytes");
  return ControlPoint{name == row.end() ? which : name->get<std::string>(), Eigen::Vector3d(p_session->data()),
                      Eigen::Vector3d(p_grid->data())};
}

Json survey_object(const Survey& survey, const Station& station) {
  const std::vector<double> residuals = residuals_m(survey);
  Json points = Json::array();
  for (std::size_t i = 0; i < survey.points.size(); ++i) {
    const auto& [name, s, g] = survey.points[i];
    points.push_back({{"name", name},
                      {"p_session", {s.x(), s.y(), s.z()}},
                      {"p_grid", {g.x(), g.y(), g.z()}},
                      {"residual_m", residuals[i]}});
  }
  Json out{{"session_id", survey.session},
           {"T_grid_session", row_major(survey.T_grid_session)},
           {"points", std::move(points)},
           {"rms_m", survey.points.empty() ? Json() : Json(rms_m(residuals))}};
  const auto blunder = blunder_of(survey.points);
  out["suspect"] = blunder ? Json{{"name", survey.points[blunder->point].name},
                                  {"off_m", blunder->off_m.norm()},
                                  {"text", blunder_text(survey.points, *blunder) + "."}}
                           : Json();
  for (const SessionRow& row : station.sessions())
    if (row.id == survey.session) out.update({{"robot", row.key.robot}, {"session", row.key.session}});
  const Atlas atlas = station.atlas().atlas;
  for (const Component& component : atlas.components) {
    const Placement* placed = placement_in(component, survey.session);
    if (!placed) continue;
    out["component"] = component.id;
    out["T_grid_component"] = row_major(survey.T_grid_session * placed->T_component_session.inverse());
  }
  return out;
}

}  // namespace

Result<Survey> survey_from_json(std::string_view body, SessionId session, bool accept) {
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object()) return broken("the body is no JSON object");
  const auto matrix = json.find("T_grid_session");
  const auto points = json.find("points");
  if ((matrix == json.end()) == (points == json.end())) return broken("one of T_grid_session and points is needed");
  Survey survey{session, Pose::Identity(), {}};
  if (matrix != json.end()) {
    const auto values = numbers<16>(json, "T_grid_session");
    if (!values) return broken("T_grid_session is not of 16 numbers");
    const auto T = checked_survey(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values->data()));
    if (!T) return tl::unexpected(T.error());
    survey.T_grid_session = *T;
    return survey;
  }
  if (!points->is_array()) return broken("points is no list");
  survey.points.reserve(points->size());
  for (std::size_t i = 0; i < points->size(); ++i) {
    auto point = control_point((*points)[i], i + 1);
    if (!point) return tl::unexpected(point.error());
    survey.points.push_back(std::move(*point));
  }
  const auto T = fit_survey(survey.points);
  if (!T) {
    const auto blunder = blunder_of(survey.points);
    return failure(T.error().code,
                   T.error().message + (blunder ? "; " + blunder_text(survey.points, *blunder) : std::string()));
  }
  survey.T_grid_session = *T;
  if (!accept)
    if (auto fits = check_fit(survey); !fits) return tl::unexpected(fits.error());
  return survey;
}

std::string survey_json(const Survey& survey, const Station& station) { return text(survey_object(survey, station)); }

std::string surveys_json(const Station& station) {
  Json rows = Json::array();
  for (const Survey& survey : station.surveys()) rows.push_back(survey_object(survey, station));
  return text({{"surveys", std::move(rows)}});
}

}  // namespace headframe
