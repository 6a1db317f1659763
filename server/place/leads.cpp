#include "server/place/leads.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/descriptor/circular.hpp"
#include "common/geometry/se3.hpp"
#include "server/support/parallel.hpp"

#include "server/session/same_placement.hpp"

namespace headframe {
namespace {

using Leads = std::vector<Lead>;
using Indices = std::vector<std::size_t>;

constexpr std::size_t laid_whole = 5;     // pieces: 360 m of path
constexpr std::size_t pairs_tried = 128;  // matched pairs of keyframes, the rarest and nearest first
constexpr double place_radius_m = 25;

/// The agreement is squared because it separates placements with fitting walls better than the walls do.
double by_promise(const Lead& lead) { return lead.promise; }
double by_coherence(const Lead& lead) { return lead.fit.strict(); }
double by_score(const Lead& lead) { return lead.fit.score(); }

Indices all_of(const Leads& leads) {
  Indices out(leads.size());
  std::iota(out.begin(), out.end(), 0);
  return out;
}

Indices either(Indices some, Indices others) {
  std::sort(some.begin(), some.end());
  std::sort(others.begin(), others.end());
  Indices out;
  std::set_union(some.begin(), some.end(), others.begin(), others.end(), std::back_inserter(out));
  return out;
}

WallMatch flat(const Pose& T) { return {yaw_rad(T), T.translation().head<2>(), 0}; }

Eigen::Vector3d middle_of(const Lead& lead) { return {lead.middle_b().x(), lead.middle_b().y(), 0}; }

WallMatch inverse(const WallMatch& m) { return {-m.yaw_rad, -middle_at({-m.yaw_rad}, m.shift_m), m.score}; }

/// The parts that support the placement of b on a most: by score, which a part that hardly meets the other level may
/// win, and, if `second`, by WallFit::lenient.
void add_best_parts(const SessionWalls::Level& a, const SessionWalls::Level& b, bool a_on_b, const WallMatch& placement,
                    bool second, Leads& out) {
  const WallMatch match = a_on_b ? inverse(placement) : placement;
  const SessionWalls::Part *by_score = nullptr, *by_walls = nullptr;
  WallFit best, most;  // of them
  for (const auto& part : (a_on_b ? a : b).parts) {
    const WallFit fit = (a_on_b ? b : a).field.fit(part.map, match);
    if (!by_score || fit.score() > best.score()) {
      by_score = &part;
      best = fit;
    }
    if (!by_walls || fit.lenient() > most.lenient()) {
      by_walls = &part;
      most = fit;
    }
  }
  if (by_score) out.push_back({&a, &b, by_score, a_on_b, match, best});
  if (second && by_walls != by_score) out.push_back({&a, &b, by_walls, a_on_b, match, most});
}

/// A placement proposed by descriptors may fit no walls nearby; then it stays where it is instead of moving to where
/// there are none.
void refine(Leads& leads, const Indices& which, WallField::Step step, const DescriptorAgreement& agreement,
            int threads) {
  for_blocks(which.size(), 4, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      Lead& lead = leads[which[i]];
      const WallField& field = lead.field();
      const WallMap& part = lead.part->map;
      const WallMatch refined = field.refine(part, lead.match, step, lead.around);
      lead.fit = field.fit(part, refined, lead.around);
      // What counts are all walls of the part, even if only its surroundings were laid.
      if ((lead.around ? field.score(part, refined) : lead.fit.score()) > 0)
        lead.match = refined;
      else
        lead.fit = field.fit(part, lead.match, lead.around);
      const Agreement alike = agreement.at(lead.T_a_b(), Heights::any);
      lead.promise = std::max(0.0, lead.fit.score()) * alike.cautious() * alike.cautious();
    }
  });
}

/// Of some, the best that differ, best first.
template <class Rank>
Indices best_of(const Leads& leads, const Indices& of, std::size_t most, Rank&& rank) {
  std::vector<std::pair<double, std::size_t>> order;
  for (const std::size_t i : of) order.emplace_back(-rank(leads[i]), i);
  std::sort(order.begin(), order.end());
  Indices kept;
  for (const auto& [worth, i] : order) {
    if (kept.size() == most) break;
    const Lead& lead = leads[i];
    const Pose T = lead.T_a_b();
    const bool known = std::any_of(kept.begin(), kept.end(), [&](std::size_t k) {
      return leads[k].a == lead.a && same_placement(leads[k].T_a_b(), T, middle_of(lead), same_hypothesis);
    });
    if (!known) kept.push_back(i);
  }
  return kept;
}

/// Appends those that fit best. Contradictions count for little, because half a cell off, a right placement has many.
void append_best(Leads leads, std::size_t most, Leads& out) {
  if (leads.size() > most) {
    std::stable_sort(leads.begin(), leads.end(),
                     [](const Lead& l, const Lead& m) { return l.fit.lenient() > m.fit.lenient(); });
    leads.resize(most);
  }
  out.insert(out.end(), leads.begin(), leads.end());
}

/// Placements from the coarse search with the parts of b that support them; and, if both_orders, with those of a.
std::vector<Leads> search(const SessionWalls& a, const SessionWalls& b, const LeadSeats& seats, int threads) {
  const std::size_t most = seats.coarse_matches;
  std::vector<Leads> found(seats.both_orders ? 2 : 1);
  const auto add = [&](const SessionWalls::Level& level_a, const SessionWalls::Level& level_b,
                       const std::vector<WallMatch>& matches, bool a_on_b) {
    std::vector<Leads> best(matches.size());
    for_blocks(matches.size(), 16, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
      for (std::size_t i = begin; i < end; ++i)
        add_best_parts(level_a, level_b, a_on_b, matches[i], seats.second_part, best[i]);
    });
    Leads all;
    for (const Leads& leads : best) all.insert(all.end(), leads.begin(), leads.end());
    append_best(std::move(all), seats.refined, found[a_on_b]);
  };
  for (const auto& level_a : a.levels)
    for (const auto& level_b : b.levels) {
      if (level_b.parts.size() <= laid_whole) {
        const auto matches = search_walls(level_a.map, level_a.field, level_b.map, most, seats.steps, threads);
        add(level_a, level_b, matches, false);
        if (seats.both_orders) add(level_a, level_b, matches, true);
        continue;
      }
      // Over hundreds of metres, drift and half a rotation step move the ends of a right placement off the walls.
      for (const auto& part : level_b.parts) {
        const auto matches =
            search_walls(level_a.map, level_a.field, part.map, most / level_b.parts.size(), seats.steps, threads);
        for (const WallMatch& m : matches) found.front().push_back({&level_a, &level_b, &part, false, m, {}});
        if (seats.both_orders) add(level_a, level_b, matches, true);
      }
    }
  return found;
}

const SessionWalls::Level* level_with(const SessionWalls& walls, std::size_t keyframe) {
  for (const auto& level : walls.levels)
    if (keyframe >= level.piece.begin && keyframe < level.piece.end) return &level;
  return nullptr;
}

const SessionWalls::Part* part_with(const SessionWalls& walls, std::size_t keyframe) {
  const auto* level = level_with(walls, keyframe);
  if (!level) return nullptr;
  const auto found =
      std::find_if(level->parts.begin(), level->parts.end(), [&](const auto& p) { return keyframe < p.piece.end; });
  return found == level->parts.end() ? nullptr : &*found;
}

}  // namespace

Pose Lead::T_a_b() const {
  const WallMatch m = a_on_b ? inverse(match) : match;
  return pose_from_yaw(m.yaw_rad, {m.shift_m.x(), m.shift_m.y(), 0});
}

std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, std::size_t most_yaws) {
  std::vector<Pose> out;
  for (const YawScore& yaw : correlate_circular(a.descriptor.w, b.descriptor.w, most_yaws))
    out.push_back(levelled(a.T_local_sensor) * pose_from_yaw(yaw.yaw_rad, Eigen::Vector3d::Zero()) *
                  levelled(b.T_local_sensor).inverse());
  return out;
}

std::vector<PlacedPair> placed_pairs(std::span<const Keyframe> of_a, std::span<const Keyframe> of_b,
                                     std::vector<MatchedPair> matches, int threads) {
  std::vector<float> popular(of_a.size(), 0);
  for (const MatchedPair& m : matches) ++popular[m.a];
  std::stable_sort(matches.begin(), matches.end(), [&](const auto& m, const auto& n) {
    return m.squared_distance * popular[m.a] < n.squared_distance * popular[n.a];
  });
  if (matches.size() > pairs_tried) matches.resize(pairs_tried);
  std::vector<std::vector<Pose>> placements(matches.size());
  for_blocks(matches.size(), 16, threads, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i)
      placements[i] = initial_transforms(of_a[matches[i].a], of_b[matches[i].b], 2);
  });
  std::vector<PlacedPair> out;
  for (std::size_t i = 0; i < matches.size(); ++i)
    for (const Pose& T : placements[i]) out.push_back({matches[i].a, matches[i].b, T});
  return out;
}

std::vector<Lead> wall_leads(const SessionWalls& a, const SessionWalls& b, const DescriptorAgreement& agreement,
                             const LeadSeats& seats, int threads) {
  Leads out;
  for (Leads& found : search(a, b, seats, threads)) {
    const Indices all = all_of(found);
    refine(found, all, WallField::Step::coarse, agreement, threads);
    // Half a cell off, a right placement contradicts in many cells: until it is refined, the score tells more.
    const Indices coherent = best_of(found, all, seats.spare / 2 * seats.coherent, by_score),
                  likely = best_of(found, all, seats.spare * seats.walls, by_promise);
    refine(found, either(coherent, likely), WallField::Step::fine, agreement, threads);
    for (const std::size_t i : best_of(found, likely, seats.walls, by_promise)) out.push_back(found[i]);
    for (const std::size_t i : best_of(found, coherent, seats.coherent, by_coherence)) {
      out.push_back(found[i]);
      out.back().source = ProposalSource::coherent_walls;
    }
  }
  return out;
}

std::vector<Lead> place_leads(const SessionWalls& a, const SessionWalls& b, std::span<const Keyframe> of_b,
                              std::span<const PlacedPair> placed, const DescriptorAgreement& agreement,
                              const LeadSeats& seats, int threads) {
  Leads found;
  for (const PlacedPair& pair : placed) {
    const auto* level = level_with(a, pair.a);
    const auto* part = part_with(b, pair.b);
    if (!level || !part) continue;
    Lead lead{level, level_with(b, pair.b), part, false, flat(pair.T_a_b), {}, ProposalSource::places};
    lead.around = {position(of_b[pair.b]).head<2>(), place_radius_m};
    lead.height_m = pair.T_a_b.translation().z();
    found.push_back(lead);
  }
  const Indices all = all_of(found);
  refine(found, all, WallField::Step::coarse, agreement, threads);
  const Indices best = best_of(found, all, seats.spare * seats.places, by_coherence);
  refine(found, best, WallField::Step::fine, agreement, threads);
  Leads out;
  for (const std::size_t i : best_of(found, best, seats.places, by_coherence)) out.push_back(found[i]);
  return out;
}

std::vector<Lead> vote_leads(const SessionWalls& a, const SessionWalls& b, std::span<const Keyframe> of_b,
                             std::span<const PlacedPair> placed, const DescriptorAgreement& agreement,
                             const LeadSeats& seats, int threads) {
  std::vector<std::pair<double, std::size_t>> order(placed.size());  // most support first, then as placed
  for_blocks(placed.size(), 1, threads, [&](std::size_t i, std::size_t, std::size_t) {
    order[i] = {-agreement.at(placed[i].T_a_b).support(), i};
  });
  std::sort(order.begin(), order.end());
  std::vector<Pose> chosen;
  for (const auto& entry : order) {
    const PlacedPair& pair = placed[entry.second];
    if (chosen.size() < seats.votes && std::none_of(chosen.begin(), chosen.end(), [&](const Pose& T) {
          return same_placement(T, pair.T_a_b, position(of_b[pair.b]), same_hypothesis);
        }))
      chosen.push_back(pair.T_a_b);
  }
  Leads out;
  for (const Pose& T : chosen)
    for (const auto& level_a : a.levels)
      for (const auto& level_b : b.levels) add_best_parts(level_a, level_b, false, flat(T), seats.second_part, out);
  for (Lead& lead : out) lead.source = ProposalSource::votes;
  for (const auto step : {WallField::Step::coarse, WallField::Step::fine})
    refine(out, all_of(out), step, agreement, threads);
  return out;
}

}  // namespace headframe
