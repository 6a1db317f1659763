#include "server/operator/trajectory_export.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "server/operator/thin_path.hpp"

namespace headframe {
namespace {

struct PlacedSession {
  SessionId component = 0;
  Pose T_frame_component = Pose::Identity();
  Placement placement;
  AtlasView view;
};

Result<PlacedSession> placed(const Station& station, SessionId session, OutputFrame frame) {
  AtlasView view = station.atlas();
  for (const Component& component : view.atlas.components)
    for (const Placement& placement : component.placements) {
      if (placement.session != session) continue;
      return frame_of(station, component, frame).map([&](const Pose& T_frame_component) {
        return PlacedSession{component.id, T_frame_component, placement, view};
      });
    }
  return failure(ErrorCode::unavailable, "the session is not in the atlas yet; try again in a moment");
}

constexpr std::size_t most_line_bytes = 640;  // a stamp may be any double, with up to 316 characters

std::string line_of(double stamp_s, const Pose& T, TrajectoryFormat format) {
  const Eigen::Vector3d t = T.translation();
  const Eigen::Quaterniond q(T.rotation());
  std::array<char, most_line_bytes> line;
  const int size = std::snprintf(line.data(), line.size(), "%.6f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", stamp_s, t.x(),
                                 t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  std::string out(line.data(), std::min(static_cast<std::size_t>(std::max(size, 0)), line.size() - 1));
  if (format == TrajectoryFormat::csv) std::replace(out.begin(), out.end(), ' ', ',');
  return out;
}

}  // namespace

Result<std::optional<std::string>> TrajectoryExport::next() {
  if (std::exchange(done_, true)) return std::nullopt;
  return text().map([](std::string piece) { return std::optional(std::move(piece)); });
}

Result<std::string> TrajectoryExport::text() const {
  const std::vector<SessionRow> sessions = station_.sessions();
  const auto row =
      std::find_if(sessions.begin(), sessions.end(), [&](const SessionRow& other) { return other.key == key_; });
  if (row == sessions.end())
    return failure(ErrorCode::not_found, "there is no session \"" + key_.robot + "/" + key_.session +
                                             "\"; the list of sessions has those there are");
  const auto session = placed(station_, row->id, frame_);
  if (!session) return tl::unexpected(session.error());
  const auto keyframes = station_.trajectory(row->id);
  if (!keyframes) return tl::unexpected(keyframes.error());
  std::string out =
      format_ == TrajectoryFormat::csv
          ? "stamp_s,x_m,y_m,z_m,qx,qy,qz,qw\n"
          : "# headframe: " +
                (frame_ == OutputFrame::grid ? std::string("the mine's grid")
                                             : "frame of component " + std::to_string(session->component)) +
                "; stamp_s x_m y_m z_m qx qy qz qw\n";
  for (const Keyframe& keyframe : *keyframes)
    out += line_of(keyframe.stamp_s,
                   session->T_frame_component * in_component(session->view, session->placement, keyframe), format_);
  return out;
}

Result<std::optional<std::string>> PathJson::next() {
  if (std::exchange(done_, true)) return std::nullopt;
  auto keyframes = station_.trajectory(session_);
  if (!keyframes) return tl::unexpected(keyframes.error());
  std::string out = R"({"columns":["sequence","stamp_s","x_m","y_m","z_m","qx","qy","qz","qw"],"keyframes":[)";
  const char* comma = "";
  std::erase_if(*keyframes, [&](const Keyframe& keyframe) { return keyframe.sequence < first_; });
  for (const Keyframe& keyframe : thin_path(std::move(*keyframes), tolerance_m_)) {
    const Eigen::Vector3d t = keyframe.T_local_sensor.translation();
    const Eigen::Quaterniond q(keyframe.T_local_sensor.rotation());
    std::array<char, most_line_bytes> row;
    const int size = std::snprintf(row.data(), row.size(), "%s[%llu,%.6f,%.3f,%.3f,%.3f,%.6f,%.6f,%.6f,%.6f]", comma,
                                   static_cast<unsigned long long>(keyframe.sequence), keyframe.stamp_s, t.x(), t.y(),
                                   t.z(), q.x(), q.y(), q.z(), q.w());
    out.append(row.data(), std::min(static_cast<std::size_t>(std::max(size, 0)), row.size() - 1));
    comma = ",";
  }
  return out + "]}\n";
}

}  // namespace headframe
