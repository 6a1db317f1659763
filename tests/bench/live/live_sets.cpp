#include "tests/bench/live/live_sets.hpp"

#include <array>
#include <cstdio>

#include "tests/bench/made_sets.hpp"

namespace headframe::bench {
namespace {

constexpr double busy = 6;  // slowness: an attempt on two cores that others fill
constexpr double as_fast_as_it_goes = 100;

/// Rates, loads, orders, clouds and mishaps, mixed so that a few drives show each.
std::vector<LiveConditions> conditions(std::size_t count, std::uint64_t seed) {
  const std::vector<LiveConditions> mixed{{1, 1, Start::together, Clouds::at_once},
                                          {6, busy, Start::together, Clouds::at_once},
                                          {6, 1, Start::last_joins_midway, Clouds::at_once},
                                          {20, busy, Start::together, Clouds::at_once},
                                          {1, busy, Start::one_after_another, Clouds::at_once},
                                          {6, 1, Start::together, Clouds::on_request},
                                          {1, 1, Start::last_joins_midway, Clouds::at_once, true},
                                          {as_fast_as_it_goes, 1, Start::together, Clouds::at_once},
                                          {1, 1, Start::together, Clouds::at_once, false, true},
                                          {20, 1, Start::one_after_another, Clouds::on_request},
                                          {6, busy, Start::together, Clouds::at_once, true},
                                          {20, 1, Start::together, Clouds::at_once},
                                          {1, busy, Start::together, Clouds::at_once},
                                          {as_fast_as_it_goes, busy, Start::one_after_another, Clouds::at_once},
                                          {6, 1, Start::together, Clouds::at_once},
                                          {1, 1, Start::together, Clouds::on_request, true}};
  std::vector<LiveConditions> out;
  for (std::size_t i = 0; i < count; ++i) {
    out.push_back(mixed[i % mixed.size()]);
    out.back().seed = seed + i;
  }
  return out;
}

std::vector<DrivenSession> read(const std::filesystem::path& folder, const std::vector<std::string>& robots,
                                const std::string& world) {
  const auto family = make_family(default_family_name).value();
  std::vector<DrivenSession> out;
  for (const std::string& robot : robots) {
    out.push_back(read_driven_session(folder, robot, *family));
    out.back().world = world;
  }
  return out;
}

/// The mine, with shorter drives where it is too small for long ones.
std::vector<DrivenSession> draw(mine::Request request) {
  for (;; request.length_m -= 20) try {
      return drive_mine(request).sessions;
    } catch (const std::runtime_error&) {
      if (request.length_m < 60) throw;
    }
}

mine::Request request_for(mine::Kind kind, std::uint64_t seed) {
  static constexpr std::array overlaps{30.0, 20.0, 45.0, 0.0, 25.0, 60.0, 35.0};
  mine::Request r;
  r.kind = kind;
  r.seed = seed;
  r.robots = seed % 3 == 0 ? 3 : 2;
  r.overlap_pct = overlaps[seed % overlaps.size()];
  r.length_m = 120;
  r.scan_spacing_m = 1;
  r.sensors = seed % 2 == 0 ? std::vector<std::string>{"os1-32", "vlp16-hires"} : std::vector<std::string>{"os1-32"};
  r.dust = 0.003;
  return r;
}

LiveSet drawn(mine::Kind kind, std::uint64_t seed, std::size_t drives) {
  const std::string name(to_string(kind));
  return {name + "-" + std::to_string(seed), name, conditions(drives, seed),
          [kind, seed] { return draw(request_for(kind, seed)); }};
}

}  // namespace

std::vector<LiveSet> live_sets(const std::filesystem::path& recordings, std::uint64_t first_seed) {
  const std::vector<std::string> four{"s1", "s2", "s3", "s4"}, two{"r1", "r2"};
  std::vector<LiveSet> sets;
  const auto recorded = [&](const std::string& name, const std::vector<std::string>& robots, const std::string& world,
                            std::size_t drives) {
    if (!std::filesystem::exists(recordings / name)) return;
    sets.push_back({name, name, conditions(drives, first_seed),
                    [folder = recordings / name, robots, world] { return read(folder, robots, world); }});
  };
  recorded("tunnel-four", four, "qualification", 16);
  if (!sets.empty() && std::filesystem::exists(recordings / "tunnel-two")) {
    LiveSet with_two = sets.back();
    with_two.name += "+two";
    with_two.kind = with_two.name;
    with_two.present = [folder = recordings / "tunnel-two", two] { return read(folder, two, "practice"); };
    sets.push_back(with_two);
  }
  recorded("tunnel-two", two, "practice", 6);
  recorded("tunnel-apart", two, "qualification", 6);
  for (std::uint64_t i = 0; i < 10; ++i) sets.push_back(drawn(mine::Kind::look_alike, first_seed + i, 8));
  static constexpr std::array others{mine::Kind::junctions, mine::Kind::grid, mine::Kind::room_and_pillar,
                                     mine::Kind::ramp, mine::Kind::straight};
  for (std::uint64_t i = 0; i < 2 * others.size(); ++i)
    sets.push_back(drawn(others[i % others.size()], first_seed + 100 + i, 8));
  return sets;
}

std::vector<LiveSet> made_live_sets(const std::vector<std::filesystem::path>& folders,
                                    const std::vector<std::string>& families) {
  constexpr std::size_t drives = 2;
  const std::vector<LiveConditions> all = conditions(16, 1);
  std::map<std::string, std::filesystem::path> last;  // of each world
  std::vector<LiveSet> sets;
  for (const auto& folder : sets_below(folders)) {
    const std::string name = folder.filename(), world = kind_of(name);
    const auto read_all = [world, families](const std::filesystem::path& set) {
      std::vector<DrivenSession> out;
      for (auto& [robot, session] : sessions_of(set, families)) {
        session.world = world;
        out.push_back(std::move(session));
      }
      return out;
    };
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(drives * sets.size() % all.size());
    sets.push_back({name, world, {first, first + drives}, [=] { return read_all(folder); }});
    if (const auto before = last.find(world); before != last.end())
      sets.back().present = [read_all, set = before->second] { return read_all(set); };
    last[world] = folder;
  }
  return sets;
}

std::string text_of(const LiveConditions& c) {
  static constexpr std::array starts{"together", "one after another", "one joins"};
  char text[96];
  std::snprintf(text, sizeof text, "%.0fx%s, %s%s%s%s", c.rate, c.slowness > 1 ? " busy" : "",
                starts.at(static_cast<std::size_t>(c.start)), c.clouds == Clouds::on_request ? ", clouds asked" : "",
                c.loses_link ? ", link lost" : "", c.restarts ? ", restart" : "");
  return text;
}

}  // namespace headframe::bench
