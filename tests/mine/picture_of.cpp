#include "tests/mine/picture_of.hpp"

namespace headframe::mine {
namespace {

picture::Layer layer_at(const Recording& recording, const std::vector<Pose>& poses, const picture::Colour& colour) {
  picture::Layer layer{.points = {}, .trajectory = {}, .colour = colour};
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const Points& points = recording.scans[i].points;
    for (std::size_t k = 0; k < points.size(); k += 2)
      layer.points.push_back((poses[i] * points[k].cast<double>()).cast<float>());
    layer.trajectory.push_back(poses[i].translation());
  }
  return layer;
}

}  // namespace

picture::Layer believed_layer(const Recording& recording, const picture::Colour& colour) {
  return layer_at(recording, recording.drive.T_local_sensor, colour);
}

picture::TopView true_picture(const std::string& title, const std::vector<Recording>& recordings) {
  picture::TopView view{.title = title,
                        .subtitle = "where the robots truly were",
                        .panels = {{.title = "truth", .layers = {}}},
                        .legend = {}};
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const picture::Colour colour = picture::colour_of(i);
    view.panels[0].layers.push_back(layer_at(recordings[i], recordings[i].drive.T_world_sensor, colour));
    view.legend.push_back({recordings[i].robot.name + " (" + recordings[i].robot.lidar.name + ")", colour});
  }
  return view;
}

}  // namespace headframe::mine
