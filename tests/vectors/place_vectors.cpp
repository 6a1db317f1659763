// What a keyframe holds: selection, levelled frame, wall profile, Scan Context, halves; and where the others lie.
#include <cmath>

#include "client/keyframe/keyframe_selector.hpp"
#include "client/transforms.hpp"
#include "common/descriptor/learned/input.hpp"
#include "common/descriptor/level.hpp"
#include "common/descriptor/scan_context.hpp"
#include "common/descriptor/wall_profile.hpp"
#include "common/security/secret.hpp"
#include "common/wire/convert.hpp"
#include "tests/vectors/vectors.hpp"

namespace headframe::vectors {
namespace {

Json exact(const Points& points) {
  Json rows = Json::array();
  for (const auto& p : points) rows.push_back({p.x(), p.y(), p.z()});
  return rows;
}

v1::Keyframe with_q(const std::vector<float>& q) {
  Keyframe keyframe;
  keyframe.descriptor.q = q;
  const auto message = to_proto(keyframe);
  return message ? *message : v1::Keyframe();
}

File halves() {
  Json values = Json::array(), qs = Json::array();
  for (const double v :
       {0.0, 1.0, -2.0, 0.1, 1.0009765, 2.00097656, 65504.0, 65519.0, 65520.0, 5.9604645e-8, 2e-8, -0.3333}) {
    const std::string half = with_q({static_cast<float>(v)}).q();
    values.push_back({{"value", v}, {"half", half.empty() ? Json() : Json(to_hex(half))}});
  }
  for (const auto& q : std::vector<std::vector<float>>{{1, 0, 2, 0, 0}, {0, 0, 0}, {0}, {1, 2}, {2e-8F, 1e-9F}})
    qs.push_back({{"q", q}, {"bytes", to_hex(with_q(q).q())}});
  return {"halves", {{"values", values}, {"q", qs}}};
}

std::vector<Pose> tilted_poses() {
  const auto turned = [](double yaw, double pitch, double roll) {
    Pose T = pose_from_yaw(yaw, {4, -5, 6});
    T.linear() = T.linear() * (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
    return T;
  };
  return {turned(0, 0, 0), turned(1.2, 0, 0), turned(-2.5, 0.2, 0), turned(0.7, -0.15, 0.3), turned(3, 0.05, -0.4)};
}

File levelled_frame() {
  const Points points{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {4, -5, 6}};
  Json rows = Json::array();
  for (const Pose& T : tilted_poses())
    rows.push_back({{"T_local_sensor", to_json(T)}, {"points_level", exact(level(T, points))}});
  return {"levelled_frame", {{"points_sensor", to_json(points)}, {"levelled", rows}}};
}

File walls() {
  Json ranges = Json::array(), scans = Json::array();
  for (const double r : {0.0, 0.29, 0.3, 0.31, 1.0, 3.0, 5.5, 20.0, 119.0, 120.0, 500.0})
    ranges.push_back({{"range_m", r}, {"code", encode_wall_range(static_cast<float>(r))}});
  const Points few{{2, 0.02F, 0}, {3, 0.03F, 0}, {9, 0.09F, 0}, {4, 0.04F, 0.4F}, {0.2F, 0.001F, 0}, {1, -0.01F, 0}};
  const Points room = room_scan(120, 12);
  const auto row = [&](const std::string& what, const Points& points_level) {
    const auto profile = wall_profile(points_level);
    scans.push_back({{"what", what},
                     {"walls", to_hex({reinterpret_cast<const char*>(profile.code.data()), profile.code.size()})},
                     {"points_level", to_json(points_level)}});
  };
  row("the median of four points, one above the band, one too near; one in the last sector", few);
  row("a room", room);
  return {"wall_profile", {{"codes", ranges}, {"scans", scans}}};
}

File scan_context() {
  Json scans = Json::array();
  const auto row = [&](const std::string& what, const Points& points_level) {
    const auto d = ScanContext().extract(points_level);
    Json out{{"what", what}, {"described", d.has_value()}};
    if (d) {
      Keyframe keyframe;
      keyframe.descriptor = *d;
      const auto message = to_proto(keyframe).value();
      out.update({{"q", d->q}, {"w", d->w}, {"q_bytes", to_hex(message.q())}, {"w_bytes", to_hex(message.w())}});
    }
    out["points_level"] = to_json(points_level);
    scans.push_back(out);
  };
  row("a room", room_scan(120, 12));
  Points far = room_scan(60, 4);
  for (auto& p : far) p *= 4;
  far.emplace_back(39.99F, 0.5F, 3);
  far.emplace_back(40.01F, 0.5F, 30);  // out of reach
  row("a hall, and a point beyond its reach", far);
  const Points few(49, Eigen::Vector3f(1, 2, 0));
  row("too few points", few);
  return {"scan_context", {{"scans", scans}}};
}

/// What the family looks at of a scan of many beams: within 11.2 deg of the horizon, here a little more.
Points band(int columns) {
  Points points = room_scan(columns, 16);
  std::erase_if(points, [](const auto& p) { return std::abs(p.z()) > 0.22F * std::hypot(p.x(), p.y()); });
  return points;
}

/// Underground: no scan is empty above the horizon on both sides, where the family adds what is of the open sky.
File learned() {
  Json scans = Json::array();
  const auto family = make_family("learned");
  Points hall = band(60), gap = band(80);
  for (auto& p : hall) p *= 4;
  std::erase_if(gap, [](const auto& p) { return p.x() > 0 && std::abs(p.y()) < 0.5F * p.x(); });
  for (const auto& [what, points_level] : {std::pair{"a hall", hall}, {"a room with a gap ahead", gap}}) {
    const auto d = (*family)->extract(points_level).value();
    Json row{{"what", what}, {"place_class", static_cast<int>(d.place_class)}, {"q", d.q}, {"w", d.w}};
    row["points_level"] = to_json(points_level);
    for (const float range_m : learned_input(points_level).range_m)
      row["image_m"].push_back(std::round(range_m * 1e3) / 1e3);
    scans.push_back(row);
  }
  return {"learned", {{"scans", scans}}};
}

File selection() {
  Json scans = Json::array();
  KeyframeSelector selector;
  const auto add = [&](double x, double yaw, float mean_range_m, double y = 0) {
    const Pose T = pose_from_yaw(yaw, {x, y, 0});
    const auto decision = selector.add(T, mean_range_m);
    scans.push_back({{"T_local_sensor", to_json(T)},
                     {"mean_range_m", mean_range_m},
                     {"keyframe", decision.keyframe},
                     {"spaciousness_m", decision.spaciousness_m}});
  };
  for (int i = 0; i < 12; ++i) add(i, 0, 4);                       // every 3 m
  for (int i = 12; i < 30; ++i) add(i, 0, 12);                     // the tunnel widens: 6, then 10 m
  for (const double yaw : {0.3, 0.6, 1.2, 0.6}) add(29, yaw, 12);  // turning on the spot
  for (int i = 29; i > 20; --i) add(i, 3.1, 12);                   // and back: where it looks another way
  add(40, 3.1, 0);                                                 // a scan without points
  for (int i = 40; i < 44; ++i) add(i, 0, 0.5F);
  for (int i = 0; i < 50; ++i)  // twice round a lap of 125 m
    add(1000 + 20 * std::cos(i * 0.2513), 0, 4, 20 * std::sin(i * 0.2513));
  return {"keyframes", {{"scans", scans}}};
}

File other_cases() {
  Transforms transforms;
  transforms.sessions = {{{"mine", "s"}, tilted_poses()[1]}, {{"other", "s"}, tilted_poses()[2]}};
  return {"transforms",
          {{"T_component_mine", to_json(tilted_poses()[1])},
           {"T_component_other", to_json(tilted_poses()[2])},
           {"T_mine_other", to_json(*transforms.T_mine_other({"mine", "s"}, {"other", "s"}))}}};
}

}  // namespace

std::vector<File> place_files() {
  std::vector<File> files{halves(), levelled_frame(), walls(), scan_context(), selection(), other_cases()};
  if (make_family("learned")) files.push_back(learned());  // not in a build without networks
  return files;
}

}  // namespace headframe::vectors
