#include <limits>

#include "server/operator/routes.hpp"

#include "server/operator/map_export.hpp"
#include "server/operator/plan.hpp"
#include "server/operator/request_target.hpp"
#include "server/operator/trajectory_export.hpp"

namespace headframe::routes {
namespace {

Result<CloudFormat> cloud_format(const Query& query) {
  const auto format = query.find("format");
  if (format == query.end() || format->second == "ply") return CloudFormat::ply;
  if (format->second == "pcd") return CloudFormat::pcd;
  if (format->second == "las") return CloudFormat::las;
  return failure(ErrorCode::invalid_argument,
                 "parameter \"format\" is \"" + format->second + "\"; give ply, pcd or las");
}

Result<double> voxel(const Query& query) {
  const auto text = query.find("voxel");
  if (text == query.end()) return ExportRequest().voxel_m;
  auto voxel_m = parse_number("voxel", text->second, 0, 100);
  if (voxel_m && *voxel_m > 0 && *voxel_m < 0.01)
    return failure(ErrorCode::invalid_argument, "parameter \"voxel\" is below 0.01; give more, or 0 for every point");
  return voxel_m;
}

Result<OutputFrame> frame_in(const Query& query) {
  const auto frame = query.find("frame");
  return frame == query.end() ? OutputFrame::component : output_frame_from(frame->second);
}

Result<PlanFormat> plan_format(const Query& query) {
  const auto format = query.find("format");
  if (format == query.end() || format->second == "png") return PlanFormat::png;
  if (format->second == "svg") return PlanFormat::svg;
  if (format->second == "pdf") return PlanFormat::pdf;
  return failure(ErrorCode::invalid_argument,
                 "parameter \"format\" is \"" + format->second + "\"; give pdf, svg or png");
}

Result<double> height(const Query& query, const char* name, double otherwise) {
  constexpr double most_m = 1e8;
  const auto text = query.find(name);
  return text == query.end() ? otherwise : parse_number(name, text->second, -most_m, most_m);
}

/// The requested component, if it can be output in the requested frame.
Result<SessionId> component_in(const Query& query, const Context& context, OutputFrame frame) {
  const auto text = required(query, "component");
  if (!text) return tl::unexpected(text.error());
  const auto id = whole(*text);
  if (!id)
    return failure(ErrorCode::invalid_argument,
                   "parameter \"component\" is \"" + *text + "\"; give the id of a component, as the atlas has it");
  const auto component = find_component(context.station.atlas().atlas, *id);
  if (!component) return tl::unexpected(component.error());
  if (const auto shown = frame_of(context.station, *component, frame); !shown) return tl::unexpected(shown.error());
  return component->id;
}

}  // namespace

Result<Reply> map(const Query& query, const Context& context) {
  const auto frame = frame_in(query);
  if (!frame) return tl::unexpected(frame.error());
  const auto format = cloud_format(query);
  if (!format) return tl::unexpected(format.error());
  const auto voxel_m = voxel(query);
  if (!voxel_m) return tl::unexpected(voxel_m.error());
  const auto component = component_in(query, context, *frame);
  if (!component) return tl::unexpected(component.error());
  return Stream{"application/octet-stream",
                std::make_unique<MapExport>(context.station, ExportRequest{*component, *format, *voxel_m, *frame})};
}

Result<Reply> plan(const Query& query, const Context& context) {
  const auto frame = frame_in(query);
  if (!frame) return tl::unexpected(frame.error());
  const auto format = plan_format(query);
  if (!format) return tl::unexpected(format.error());
  const auto scale = whole_number(query, "scale", 0, 100000);
  const auto low_m = height(query, "low", -std::numeric_limits<double>::infinity());
  const auto high_m = height(query, "high", std::numeric_limits<double>::infinity());
  if (!scale) return tl::unexpected(scale.error());
  for (const auto* limit : {&low_m, &high_m})
    if (!*limit) return tl::unexpected(limit->error());
  const auto component = component_in(query, context, *frame);
  if (!component) return tl::unexpected(component.error());
  const char* type = *format == PlanFormat::pdf   ? "application/pdf"
                     : *format == PlanFormat::svg ? "image/svg+xml"
                                                  : "image/png";
  return Stream{type, std::make_unique<Plan>(context.station, PlanRequest{*component, *frame, *format,
                                                                          static_cast<int>(*scale), *low_m, *high_m})};
}

Result<Reply> trajectory(const Query& query, const Context& context) {
  const auto robot = required(query, "robot");
  if (!robot) return tl::unexpected(robot.error());
  const auto session = required(query, "session");
  if (!session) return tl::unexpected(session.error());
  const auto format = query.find("format");
  const bool csv = format != query.end() && format->second == "csv";
  if (format != query.end() && !csv && format->second != "tum")
    return failure(ErrorCode::invalid_argument, "parameter \"format\" is \"" + format->second + "\"; give tum or csv");
  const auto frame = frame_in(query);
  if (!frame) return tl::unexpected(frame.error());
  return Stream{csv ? "text/csv; charset=utf-8" : "text/plain; charset=utf-8",
                std::make_unique<TrajectoryExport>(context.station, SessionKey{*robot, *session},
                                                   csv ? TrajectoryFormat::csv : TrajectoryFormat::tum, *frame)};
}

}  // namespace headframe::routes
