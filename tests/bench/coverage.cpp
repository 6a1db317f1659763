#include "tests/bench/coverage.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "common/descriptor/family.hpp"
#include "server/net/surroundings_desk.hpp"
#include "server/net/surroundings_pages.hpp"
#include "tests/bench/driven_session.hpp"
#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

constexpr double new_tunnel_m = 50, apart_m = 1000, drive_m = 250;
constexpr std::size_t most_tiles = 100000;

using Drives = std::vector<std::vector<Keyframe>>;

double path_m(const std::vector<Keyframe>& keyframes) {
  double sum_m = 0;
  for (std::size_t i = 1; i < keyframes.size(); ++i)
    sum_m += (position(keyframes[i]) - position(keyframes[i - 1])).norm();
  return sum_m;
}

/// A mine of drives that share nothing, as the server holds it, and a robot that is told of it.
class Mine {
 public:
  explicit Mine(const Drives& drives) : drives_(drives) {
    around_.component.id = around_.receiver = 1;
    for (std::size_t i = 0; i < drives.size(); ++i) {
      const auto id = static_cast<SessionId>(i + 1);
      const double turn_rad = 0.7 * static_cast<double>(i);
      around_.component.placements.push_back({id, pose_from_yaw(turn_rad, {apart_m * static_cast<double>(i), 7, 0})});
      around_.keys[id] = {"robot-" + std::to_string(i % 8), "session-" + std::to_string(i)};
    }
  }

  void durable(std::size_t drive, std::uint64_t keyframes) {
    around_.durable[static_cast<SessionId>(drive + 1)] = keyframes;
    const auto read = [&](SessionId session, std::uint64_t first, const std::function<void(Keyframe)>& visit) {
      const auto& all = drives_[static_cast<std::size_t>(session - 1)];
      for (std::uint64_t s = first; s <= around_.durable[session]; ++s) visit(all[s - 1]);
      return Result<void>();
    };
    (void)map_.refresh(around_.component, around_.durable, read, [] { return false; });
  }

  struct Told {
    std::size_t coverage_bytes = 0, path_bytes = 0;
  };
  /// All that is new to the robot, as messages of the protocol.
  Told tell() {
    Told told;
    const ComponentMaps::Known known{&map_, 1ULL << 63};
    while (const auto piece = map_.coverage_after(coverage_.version, SurroundingsDesk::least_page_bytes)) {
      told.coverage_bytes += coverage_page(around_, coverage_, known, *piece, 0).ByteSizeLong();
      coverage_ = {known.epoch, piece->version};
    }
    while (const auto piece = map_.paths_after(paths_.version, 1, SurroundingsDesk::least_page_bytes)) {
      told.path_bytes += trajectories_page(around_, paths_, known, *piece, 0).ByteSizeLong();
      paths_ = {known.epoch, piece->version};
    }
    return told;
  }

 private:
  const Drives& drives_;
  SessionSurroundings around_;
  ComponentMap map_{most_tiles};
  HeldVersion coverage_, paths_;
};

nlohmann::json told_of(const char* what, const Drives& drives) {
  double km = 0;
  for (const auto& drive : drives) km += path_m(drive) / 1000;
  Mine whole(drives);
  for (std::size_t i = 0; i < drives.size(); ++i) whole.durable(i, drives[i].size());
  const Mine::Told all = whole.tell();

  Mine growing(drives);
  std::vector<double> updates, path_updates;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    double since_m = 0;
    growing.durable(i, 1);
    (void)growing.tell();
    for (std::size_t k = 1; k < drives[i].size(); ++k) {
      since_m += (position(drives[i][k]) - position(drives[i][k - 1])).norm();
      if (since_m < new_tunnel_m) continue;
      since_m = 0;
      growing.durable(i, k + 1);
      const Mine::Told update = growing.tell();
      updates.push_back(static_cast<double>(update.coverage_bytes));
      path_updates.push_back(static_cast<double>(update.path_bytes));
    }
  }
  const double worst = updates.empty() ? 0 : *std::max_element(updates.begin(), updates.end());
  std::printf(
      "  %-9s %5.2f km, %3zu drives: coverage %6.1f KB (%.1f KB for 10 km), paths %5.1f KB; after 50 m more: "
      "coverage %4.0f bytes (median of %zu), %4.0f at most; paths %3.0f bytes\n",
      what, km, drives.size(), static_cast<double>(all.coverage_bytes) / 1e3,
      static_cast<double>(all.coverage_bytes) / 1e3 / km * 10, static_cast<double>(all.path_bytes) / 1e3,
      updates.empty() ? 0 : median(updates), updates.size(), worst, path_updates.empty() ? 0 : median(path_updates));
  return {{"km", km},
          {"coverage_bytes", all.coverage_bytes},
          {"path_bytes", all.path_bytes},
          {"coverage_update_median_bytes", updates.empty() ? 0 : median(updates)},
          {"coverage_update_most_bytes", worst}};
}

Drives drawn(const CoverageBench& bench) {
  Drives drives;
  constexpr std::array kinds{mine::Kind::junctions, mine::Kind::grid, mine::Kind::varied, mine::Kind::room_and_pillar};
  double km = 0;
  for (std::uint64_t n = 0; km < bench.mine_km; ++n) {
    mine::Request request;
    request.kind = kinds[n % kinds.size()];
    request.seed = bench.first_seed + n;
    request.robots = 1;
    request.length_m = drive_m;
    request.scan_spacing_m = 1;
    try {
      for (DrivenSession& session : drive_mine(request).sessions) {
        drives.push_back(std::move(session.keyframes));
        km += path_m(drives.back()) / 1000;
      }
    } catch (const std::runtime_error&) {  // the mine is too small for such a drive
      if (n > 1000) throw;
    }
  }
  return drives;
}

Drives recorded(const std::filesystem::path& folder) {
  Drives drives;
  if (!std::filesystem::is_directory(folder)) return drives;
  const auto family = make_family("scan_context");
  std::vector<std::filesystem::path> sets;
  for (const auto& set : std::filesystem::directory_iterator(folder)) sets.push_back(set.path());
  std::sort(sets.begin(), sets.end());
  for (const auto& set : sets) {
    if (!std::filesystem::is_directory(set)) continue;
    std::vector<std::string> robots;
    for (const auto& robot : std::filesystem::directory_iterator(set))
      if (std::filesystem::exists(robot.path() / "poses.txt")) robots.push_back(robot.path().filename());
    std::sort(robots.begin(), robots.end());
    for (const std::string& robot : robots) drives.push_back(read_driven_session(set, robot, **family).keyframes);
  }
  return drives;
}

}  // namespace

nlohmann::json coverage(const CoverageBench& bench) {
  std::printf("coverage\n");
  nlohmann::json figures;
  if (const Drives drives = recorded(bench.recordings); !drives.empty())
    figures["recorded"] = told_of("recorded", drives);
  figures["drawn"] = told_of("drawn", drawn(bench));
  return figures;
}

}  // namespace headframe::bench
