#include "tests/bench/descriptors/descriptors.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "tests/bench/descriptors/costs.hpp"
#include "tests/bench/descriptors/figures.hpp"
#include "tests/bench/descriptors/hypothesis_rank.hpp"
#include "tests/bench/descriptors/own_mines.hpp"
#include "tests/bench/descriptors/trial.hpp"

namespace headframe::bench {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double off_grid_deg = 0.43;  // added to every yaw shift: whole degrees only move the sectors of some families

/// A data set and its pairs of robots that overlap.
struct RecordedSet {
  const char *name, *row;
  bool underground;  // there the hypotheses are ranked, too
  std::vector<std::pair<const char*, const char*>> pairs;
};

std::vector<RecordedSet> recorded_sets() {
  return {{"tunnel-two", "tunnel_two", true, {{"r1", "r2"}}},
          {"tunnel-four", "tunnel_four", true, {{"s1", "s2"}, {"s2", "s3"}, {"s3", "s4"}}},
          {"nclt-two-robots", "nclt", false, {{"a", "b"}}}};
}

Result<std::vector<FamilyFigures>> open_families(const std::vector<std::string>& names) {
  std::vector<FamilyFigures> out;
  for (const std::string& name : names) {
    auto made = make_family(name);
    if (!made) return tl::unexpected(made.error());
    FamilyFigures figures;
    figures.name = name;
    figures.family = std::move(*made);
    out.push_back(std::move(figures));
  }
  return out;
}

void count_junctions(FamilyFigures& f, const std::vector<Descriptor>& told, const std::vector<bool>& truth) {
  for (std::size_t i = 0; i < told.size(); ++i) {
    if (told[i].place_class == PlaceClass::unknown) continue;
    f.tells_class = true;
    f.junctions.add(truth[i], told[i].place_class == PlaceClass::junction);
  }
}

/// Only keyframes with a right answer are turned and asked.
void try_shifts(FamilyFigures& f, const std::string& row, const std::vector<Descriptor>& a, const Drive& b,
                const Truth& truth) {
  Drive queries;
  Truth asked{{}, truth.yaw_a_rad, {}};
  for (std::size_t j = 0; j < b.size(); ++j) {
    if (truth.right[j].empty()) continue;
    queries.push_back(b[j]);
    asked.right.push_back(truth.right[j]);
    asked.yaw_b_rad.push_back(truth.yaw_b_rad[j]);
  }
  auto& by_shift = f.by_shift[row];
  by_shift.resize(shift_last_deg / shift_step_deg + 1);
  for (std::size_t k = 0; k < by_shift.size(); ++k) {
    const double shift_rad = k == 0 ? 0 : (shift_step_deg * static_cast<double>(k) + off_grid_deg) * degree;
    const Answers answers = ask(*f.family, a, describe(*f.family, queries, shift_rad), asked);
    by_shift[k].insert(by_shift[k].end(), answers.begin(), answers.end());
  }
}

/// The drives of one mine as they were seen, in dust and tilted; kinds out of the headline in clean air only.
void try_mine(FamilyFigures& f, const OwnMine& mine, const Drives& tilted) {
  const DescriptorFamily& family = *f.family;
  const auto a = describe(family, mine.clean.a), b_same = describe(family, mine.clean.b_same),
             b_cross = describe(family, mine.clean.b_cross);
  const Answers same = ask(family, a, b_same, mine.same), cross = ask(family, a, b_cross, mine.cross);
  if (in_headline(mine.kind)) {
    f.add("same", same);
    f.add("cross", cross);
    for (const auto& [suffix, drives] :
         {std::pair<std::string, const Drives&>{"_dust", mine.dusty}, {"_tilt", tilted}}) {
      const auto harder_a = describe(family, drives.a);
      f.add("same" + suffix, ask(family, harder_a, describe(family, drives.b_same), mine.same));
      f.add("cross" + suffix, ask(family, harder_a, describe(family, drives.b_cross), mine.cross));
    }
    try_shifts(f, "same", a, mine.clean.b_same, mine.same);
    try_shifts(f, "cross", a, mine.clean.b_cross, mine.cross);
    count_junctions(f, a, mine.junction_a);
    count_junctions(f, b_same, mine.junction_b);
    count_junctions(f, b_cross, mine.junction_b);
  }
  const std::string kind(to_string(mine.kind));
  f.add(kind + "_same", same);
  f.add(kind + "_cross", cross);
}

Drives tilted_drives(const OwnMine& mine) {
  const auto tilt = [&](const Drive& drive, std::uint64_t salt) { return tilted(drive, 10 * mine.seed + salt); };
  return {tilt(mine.clean.a, 1), tilt(mine.clean.b_same, 2), tilt(mine.clean.b_cross, 3)};
}

Result<void> try_own_mines(std::vector<FamilyFigures>& families, int mines_a_kind) {
  const auto all = static_cast<std::size_t>(mines_a_kind) * own_kinds.size();
  for (std::size_t n = 0; n < all; ++n) {
    std::fprintf(stderr, "\rmines %zu of %zu", n + 1, all);
    const auto mine = dig(own_kinds[n % own_kinds.size()], first_own_seed + n / own_kinds.size());
    if (!mine) return tl::unexpected(mine.error());
    const Drives tilted = tilted_drives(*mine);
    for (FamilyFigures& f : families) try_mine(f, *mine, tilted);
  }
  std::fprintf(stderr, "\n");
  return {};
}

void try_recorded_drives(FamilyFigures& f, const std::string& row, const Drive& a, const Drive& b) {
  const DescriptorFamily& family = *f.family;
  const Truth truth = truth_of(a, b);
  const auto of_a = describe(family, a), of_b = describe(family, b);
  f.add(row, ask(family, of_a, of_b, truth));
  f.add(row + "_back", ask(family, of_b, of_a, truth_of(b, a)));
  f.add(row + "_tilt", ask(family, describe(family, tilted(a, 1)), describe(family, tilted(b, 2)), truth));
}

void rank_hypotheses(FamilyFigures& f, const std::string& row, const std::filesystem::path& folder,
                     const std::string& a, const std::string& b) {
  const DrivenSession session_a = read_driven_session(folder, a, *f.family),
                      session_b = read_driven_session(folder, b, *f.family);
  f.hypothesis_ranks.emplace_back(std::string(row).append("_").append(a).append("_").append(b),
                                  rank_of_right_hypothesis(session_a, session_b));
}

void try_recordings(std::vector<FamilyFigures>& families, const std::filesystem::path& recordings) {
  for (const RecordedSet& set : recorded_sets()) {
    const auto folder = recordings / set.name;
    if (!std::filesystem::exists(folder)) {
      std::printf("descriptors: no recording at %s, its rows are left out\n", folder.c_str());
      continue;
    }
    std::fprintf(stderr, "%s\n", set.name);
    for (const auto& [a, b] : set.pairs) {
      const Drive drive_a = read_drive(folder, a), drive_b = read_drive(folder, b);
      for (FamilyFigures& f : families) {
        try_recorded_drives(f, set.row, drive_a, drive_b);
        if (set.underground) rank_hypotheses(f, set.row, folder, a, b);
      }
    }
  }
}

Result<void> measure_costs(std::vector<FamilyFigures>& families) {
  const auto dense = dense_recording();
  if (!dense) return tl::unexpected(dense.error());
  for (FamilyFigures& f : families) {
    f.extract = time_extraction(*f.family, *dense);
    const auto one = f.family->extract(drive_of(*dense).front().points_level);
    if (!one) return tl::unexpected(one.error());
    f.bytes = wire_bytes(*one);
    const auto last = std::find_if(one->q.rbegin(), one->q.rend(), [](float v) { return v != 0; });
    f.query_all = time_query_all(one->q.size(), static_cast<std::size_t>(one->q.rend() - last));
    f.query_all_whole = time_query_all(one->q.size(), one->q.size());
  }
  return {};
}

}  // namespace

Result<nlohmann::json> descriptors(const DescriptorBench& bench) {
  auto families = open_families(bench.families);
  if (!families) return tl::unexpected(families.error());
  if (auto ok = measure_costs(*families); !ok) return tl::unexpected(ok.error());
  if (auto ok = try_own_mines(*families, bench.mines); !ok) return tl::unexpected(ok.error());
  try_recordings(*families, bench.recordings);
  std::printf(
      "descriptors: %d mines of each kind from seed %llu on; `same` and `cross` are over junctions, grid, "
      "room_and_pillar and ramp\n",
      bench.mines, static_cast<unsigned long long>(first_own_seed));
  print_tables(*families);
  std::filesystem::create_directories(bench.pictures);
  if (auto drawn = draw_pictures(*families, bench.pictures); !drawn) return tl::unexpected(drawn.error());
  nlohmann::json out{{"descriptors", {{"mines_a_kind", bench.mines}, {"first_seed", first_own_seed}}},
                     {"query_all_ms", families->front().query_all.median_ms}};
  for (const FamilyFigures& f : *families) out[f.name] = to_json(f);
  return out;
}

}  // namespace headframe::bench
