#include "tests/bench/basin.hpp"

#include <array>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <thread>

#include "server/picture/canvas.hpp"
#include "server/registration/vgicp.hpp"
#include "server/support/parallel.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/registration/gicp.hpp"
#include "tests/mine/scenario.hpp"

namespace headframe::bench {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double success_m = 0.5, success_deg = 2;
constexpr std::array<double, 6> radii_m{5, 10, 15, 20, 25, 30};
constexpr std::array<double, 7> yaws_deg{0, 10, 20, 30, 40, 50, 60};
constexpr std::array<double, 6> distances_m{0, 2, 4, 6, 8, 10};
constexpr std::size_t directions = 3;  // in which a start is off, for every pair of spheres
constexpr std::size_t cells = yaws_deg.size() * distances_m.size();

/// Two robots' drives without drift, in the world's frame, less the place where they come nearest.
struct Drives {
  std::array<Points, 2> points;
};

Drives drive(mine::Kind kind, std::uint64_t seed) {
  mine::Request request;
  request.kind = kind;
  request.seed = seed;
  request.overlap_pct = 40;
  request.length_m = 80;
  request.drift = 0;
  const auto scenario = mine::make_scenario(request);
  if (!scenario) throw std::runtime_error("basin: the scenario was refused");
  std::array<mine::Recording, 2> recordings;
  for (std::size_t r = 0; r < 2; ++r) recordings[r] = mine::record(scenario->world, scenario->robots[r], seed);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double nearest = std::numeric_limits<double>::max();
  for (const Pose& a : recordings[0].drive.T_world_sensor)
    for (const Pose& b : recordings[1].drive.T_world_sensor)
      if (const double d = (a.translation() - b.translation()).norm(); d < nearest) {
        nearest = d;
        centre = b.translation();
      }
  Drives out;
  for (std::size_t r = 0; r < 2; ++r) {
    for (std::size_t i = 0; i < recordings[r].scans.size(); ++i) {
      const Pose T = Eigen::Translation3d(-centre) * recordings[r].drive.T_world_sensor[i];
      for (const auto& p : recordings[r].scans[i].points) out.points[r].push_back((T * p.cast<double>()).cast<float>());
    }
    out.points[r] = voxel_grid(out.points[r], 0.4F);
  }
  return out;
}

struct Spheres {
  Surfels target, source;
  VoxelMaps maps;
};

Spheres cut(const Drives& drives, double radius_m) {
  const auto within = [&](const Points& points) {
    Points out;
    for (const auto& p : points)
      if (static_cast<double>(p.norm()) < radius_m) out.push_back(p);
    return make_surfels(out);
  };
  Spheres out{within(drives.points[0]), within(drives.points[1]), {}};
  out.maps = make_voxel_maps(out.target.points, out.target.normals);
  return out;
}

bool found(const Registration& r) {
  return r.status != RegistrationStatus::too_little_overlap && r.T_target_source.translation().norm() < success_m &&
         rotation_angle_rad(r.T_target_source) < success_deg * degree;
}

/// Shares of success by cell: yaw fastest. [0]: GICP, [1]: VGICP.
using Table = std::array<std::array<double, cells>, 2>;

Table measure(const std::vector<Spheres>& pairs, int threads) {
  Table table{};
  for_blocks(cells, 1, threads, [&](std::size_t cell, std::size_t, std::size_t) {
    std::mt19937 rng(static_cast<unsigned>(cell));
    std::uniform_real_distribution<double> any(0, 2 * std::numbers::pi);
    const double yaw = yaws_deg[cell % yaws_deg.size()] * degree, distance = distances_m[cell / yaws_deg.size()];
    for (const Spheres& s : pairs)
      for (std::size_t i = 0; i < directions; ++i) {
        const double to = any(rng);
        const Pose start =
            pose_from_yaw(i % 2 == 0 ? yaw : -yaw, {distance * std::cos(to), distance * std::sin(to), 0});
        table[0][cell] += found(align(s.target, s.source, start, {}));
        table[1][cell] += found(align(s.maps, s.source.points, s.source.normals, start));
      }
    for (auto& engine : table) engine[cell] /= static_cast<double>(pairs.size() * directions);
  });
  return table;
}

picture::Colour colour_of_share(double share) {
  const auto s = static_cast<float>(share);
  return {0.75F * (1 - s) + 0.15F * s, 0.15F + 0.55F * s, 0.2F + 0.1F * s};
}

/// One panel: yaw to the right, distance down, percent in each cell.
void draw_panel(picture::Canvas& canvas, int left, int top, const std::string& title,
                const std::array<double, cells>& shares) {
  constexpr int size = 30;
  const picture::Colour ink = picture::Colour::Constant(0.9F);
  canvas.text(left, top, title, 1, ink);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const int column = static_cast<int>(cell % yaws_deg.size()), row = static_cast<int>(cell / yaws_deg.size());
    const int x = left + 24 + column * size, y = top + 14 + row * size;
    canvas.fill(x, y, size - 1, size - 1, colour_of_share(shares[cell]));
    canvas.text(x + 5, y + 11, std::to_string(std::lround(100 * shares[cell])), 1, ink);
    if (row == 0)
      canvas.text(x + 5, top + 16 + static_cast<int>(distances_m.size()) * size,
                  std::to_string(std::lround(yaws_deg[cell % yaws_deg.size()])), 1, ink);
    if (column == 0)
      canvas.text(left, y + 11, std::to_string(std::lround(distances_m[cell / yaws_deg.size()])), 1, ink);
  }
}

void draw(const std::vector<Table>& tables, const std::filesystem::path& file) {
  constexpr int width = 250, height = 220;
  picture::Canvas canvas(width * static_cast<int>(radii_m.size()) + 20, 2 * height + 40,
                         picture::Colour::Constant(0.08F));
  canvas.text(10, 8,
              "Success in percent (within 0.5 m and 2 deg). To the right: yaw error, deg. Down: start off by, m.", 2,
              picture::Colour::Constant(0.95F));
  for (std::size_t r = 0; r < radii_m.size(); ++r)
    for (std::size_t engine = 0; engine < 2; ++engine)
      draw_panel(canvas, 10 + width * static_cast<int>(r), 36 + height * static_cast<int>(engine),
                 std::string(engine == 0 ? "GICP" : "VGICP") + ", spheres of " +
                     std::to_string(std::lround(radii_m[r])) + " m",
                 tables[r][engine]);
  if (const auto written = canvas.write_png(file); !written)
    std::fprintf(stderr, "headframe-bench: %s was not written\n", file.c_str());
}

double mean(const std::array<double, cells>& shares) {
  double sum = 0;
  for (const double s : shares) sum += s;
  return sum / static_cast<double>(cells);
}

}  // namespace

nlohmann::json basin(const std::filesystem::path& out) {
  const std::vector<Drives> drives{drive(mine::Kind::junctions, 1), drive(mine::Kind::junctions, 2),
                                   drive(mine::Kind::junctions, 3), drive(mine::Kind::room_and_pillar, 1)};
  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::printf("basin (%zu pairs of drives, %zu starts a cell; success: within %.1f m and %.0f deg)\n", drives.size(),
              drives.size() * directions, success_m, success_deg);
  nlohmann::json figures{{"yaws_deg", yaws_deg}, {"distances_m", distances_m}};
  std::vector<Table> tables;
  for (const double radius_m : radii_m) {
    std::vector<Spheres> pairs;
    pairs.reserve(drives.size());
    for (const Drives& d : drives) pairs.push_back(cut(d, radius_m));
    const Table& table = tables.emplace_back(measure(pairs, threads));
    const std::size_t near = yaws_deg.size() + 2;  // 2 m and 20 deg
    std::printf("  %2.0f m   GICP %3.0f %% of all starts, %3.0f %% at 2 m and 20 deg   VGICP %3.0f %%, %3.0f %%\n",
                radius_m, 100 * mean(table[0]), 100 * table[0][near], 100 * mean(table[1]), 100 * table[1][near]);
    std::fflush(stdout);
    figures["radius_" + std::to_string(std::lround(radius_m)) + "m"] = {{"gicp", table[0]}, {"vgicp", table[1]}};
  }
  draw(tables, out / "basin.png");
  std::printf("  drawn in %s\n", (out / "basin.png").c_str());
  return figures;
}

}  // namespace headframe::bench
