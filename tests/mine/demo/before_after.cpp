#include "tests/mine/demo/before_after.hpp"

#include "common/dataset/session_folder.hpp"
#include "server/picture/top_view.hpp"

namespace headframe::demo {
namespace {

Result<picture::Layer> layer_of(const std::filesystem::path& session, const picture::Colour& colour) {
  auto folder = SessionFolder::open(session);
  if (!folder) return tl::unexpected(folder.error());
  picture::Layer layer;
  layer.colour = colour;
  for (std::size_t i = 0; i < folder->size(); ++i) {
    const Pose& T_local_sensor = folder->T_local_sensor(i);
    layer.trajectory.push_back(T_local_sensor.translation());
    auto scan = folder->load(i);
    if (!scan) return tl::unexpected(scan.error());
    for (std::size_t k = 0; k < scan->points.size(); k += 3)
      layer.points.push_back((T_local_sensor * scan->points[k].cast<double>()).cast<float>());
  }
  return layer;
}

std::string subtitle_of(const std::vector<RobotOutcome>& robots) {
  const std::size_t together = count_together(robots);
  if (together < 2) return "seen from above; no two maps merged";
  double error_m = 0, error_deg = 0;
  for (const RobotOutcome& robot : robots) {
    error_m = std::max(error_m, robot.error_m);
    error_deg = std::max(error_deg, robot.error_deg);
  }
  char text[160];
  std::snprintf(text, sizeof text,
                "seen from above; %zu of %zu maps merged; largest error where maps overlap: %.2f m, %.2f deg", together,
                robots.size(), error_m, error_deg);
  return text;
}

}  // namespace

Result<void> draw_before_after(const std::filesystem::path& recordings, const std::vector<RobotOutcome>& robots,
                               const std::filesystem::path& png) {
  picture::TopView view{.title = std::to_string(robots.size()) + " robots in one mine",
                        .subtitle = subtitle_of(robots),
                        .panels = {},
                        .legend = {}};
  picture::Panel before{"before: every robot in its own frame", {}},
      after{"after: in one frame, as headframe merged them", {}};
  const auto shown = largest_component(robots);
  Pose T_first_component = Pose::Identity();  // the first robot's map lies the same way in both halves
  if (!robots.empty() && robots.front().component == shown)
    T_first_component = robots.front().T_component_session.inverse();
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const RobotOutcome& robot = robots[i];
    auto layer = layer_of(recordings / robot.name, picture::colour_of(i));
    if (!layer) return tl::unexpected(layer.error());
    before.layers.push_back(*layer);
    layer->T_view_cloud = T_first_component * robot.T_component_session;
    if (robot.component && robot.component == shown) after.layers.push_back(std::move(*layer));
    view.legend.push_back({robot.name + " (" + robot.sensor + ")", picture::colour_of(i)});
  }
  view.panels = {std::move(before), std::move(after)};
  return picture::write_png(view, png);
}

}  // namespace headframe::demo
