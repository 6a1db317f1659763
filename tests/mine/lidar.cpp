#include "tests/mine/lidar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headframe::mine {
namespace {

constexpr double dust_reach_m = 15;  // beyond it a grain returns too little light

/// Where dust in the ray answers, if it does before the wall.
std::optional<double> dust_range_m(double dust, double wall_m, Rng& rng) {
  if (dust <= 0) return std::nullopt;
  const double range_m = -std::log(1.0 - rng.uniform()) / dust;
  if (range_m > std::min(wall_m, dust_reach_m)) return std::nullopt;
  return range_m;
}

bool lost(const LidarModel& model, const Hit& hit, Rng& rng) {
  if (model.dropout <= 0) return false;
  const double grazing = std::clamp(1.0 - hit.incidence / 0.08, 0.0, 1.0);
  const double far = std::pow(hit.range_m / model.max_range_m, 2);
  return rng.chance(std::min(1.0, model.dropout + 0.6 * grazing + 0.3 * far));
}

}  // namespace

std::optional<LidarModel> lidar_model(std::string_view name) {
  if (name == "os1-32") return LidarModel{.name = "os1-32"};
  if (name == "vlp16-hires")
    return LidarModel{.name = "vlp16-hires",
                      .beams = 16,
                      .columns = 450,
                      .fov_up_deg = 10,
                      .fov_down_deg = -10,
                      .max_range_m = 100,
                      .range_sigma_m = 0.03};
  if (name == "hdl-32e")
    return LidarModel{.name = "hdl-32e",
                      .beams = 32,
                      .columns = 360,
                      .fov_up_deg = 10.67,
                      .fov_down_deg = -30.67,
                      .min_range_m = 0.8,
                      .max_range_m = 100};
  if (name == "os0-64")
    return LidarModel{.name = "os0-64",
                      .beams = 64,
                      .columns = 256,
                      .fov_up_deg = 45,
                      .fov_down_deg = -45,
                      .min_range_m = 0.3,
                      .max_range_m = 50,
                      .range_sigma_m = 0.015};
  return std::nullopt;
}

LidarModel noiseless(LidarModel model) {
  model.range_sigma_m = 0;
  model.dropout = 0;
  return model;
}

Scan take_scan(const RayCaster& caster, const LidarModel& model, const Pose& T_world_sensor, double dust, Rng rng) {
  const double deg = std::numbers::pi / 180;
  const Eigen::Vector3f origin = T_world_sensor.translation().cast<float>();
  Scan scan;
  for (int column = 0; column < model.columns; ++column) {
    const double azimuth = 2 * std::numbers::pi * column / model.columns;
    for (int beam = 0; beam < model.beams; ++beam) {
      const double share = model.beams > 1 ? static_cast<double>(beam) / (model.beams - 1) : 0.5;
      const double elevation = deg * (model.fov_up_deg + share * (model.fov_down_deg - model.fov_up_deg));
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      const auto hit =
          caster.cast(origin, (T_world_sensor.linear() * ray).cast<float>(), static_cast<float>(model.max_range_m));
      double range_m = hit ? hit->range_m : model.max_range_m;
      const auto grain_m = dust_range_m(dust, range_m, rng);
      if (!grain_m && (!hit || lost(model, *hit, rng))) continue;
      if (grain_m) range_m = *grain_m;
      if (model.range_sigma_m > 0) range_m += model.range_sigma_m * rng.normal();
      if (range_m < model.min_range_m || range_m > model.max_range_m) continue;
      scan.points.emplace_back((range_m * ray).cast<float>());
      scan.intensity.push_back(grain_m ? 0.05F : 0.2F + 0.6F * hit->incidence);
    }
  }
  return scan;
}

}  // namespace headframe::mine
