#include "server/place/hypotheses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/descriptor/circular.hpp"
#include "server/place/descriptor_agreement.hpp"
#include "server/place/leads.hpp"
#include "server/place/likely_height.hpp"

#include "server/session/same_placement.hpp"
#include "server/support/parallel.hpp"

namespace headframe {
namespace {

/// For searches that have to be fast, and for a session on itself: how alike its places are was measured with it.
WallSearchSteps rough(const WallSearchSteps& steps) {
  return {std::max(1.5F, steps.cell_m), steps.quarter_turns, 2 * steps.peaks, 3};
}

bool has_walls(const WallProfile& walls) {
  return std::any_of(walls.code.begin(), walls.code.end(), [](std::uint8_t code) { return code != 0; });
}

/// The middle of the walls of the part that met, at the height of the nearest keyframe.
Eigen::Vector3d place_of(const Lead& lead, std::span<const Keyframe> part) {
  Eigen::Vector3d out = position(part[part.size() / 2]);
  if (lead.fit.met == 0) return out;
  double nearest = std::numeric_limits<double>::max();
  const Eigen::Vector2d middle = lead.middle_b();
  for (const Keyframe& k : part)
    if (const double d = (position(k).head<2>() - middle).squaredNorm(); d < nearest) {
      nearest = d;
      out.z() = position(k).z();
    }
  out.head<2>() = middle;
  return out;
}

}  // namespace

/// They are drawn anew whenever the keyframes changed, also where only an outlier lost its walls: what is found must
/// not depend on when the session was searched before.
std::vector<HypothesisFinder::WallsPtr> HypothesisFinder::walls(std::span<const SessionView> sessions) {
  std::vector<Drawn> drawn;
  std::vector<std::size_t> missing;
  for (const SessionView& session : sessions) {
    const auto with_walls = std::count_if(session.keyframes.begin(), session.keyframes.end(),
                                          [](const Keyframe& k) { return has_walls(k.walls); });
    drawn.push_back({nullptr, session.keyframes.size(), static_cast<std::size_t>(with_walls)});
    Drawn& now = drawn.back();
    if (const Drawn* known = walls_.find(session.id)) {
      if (known->walls->path_m == path_m(session.keyframes) && known->keyframes == now.keyframes &&
          known->with_walls == now.with_walls)
        now.walls = known->walls;
      else
        walls_bytes_ -= walls_.drop(session.id).walls->bytes();
    }
    if (!now.walls) missing.push_back(drawn.size() - 1);
  }
  for_blocks(missing.size(), 1, config_.threads, [&](std::size_t i, std::size_t, std::size_t) {
    drawn[missing[i]].walls = std::make_shared<const SessionWalls>(sessions[missing[i]].keyframes);
  });
  for (const std::size_t i : missing) {
    walls_.put(sessions[i].id, drawn[i]);
    walls_bytes_ += drawn[i].walls->bytes();
  }
  while (walls_bytes_ > config_.walls_bytes && walls_.size() > 1) walls_bytes_ -= walls_.drop_oldest().walls->bytes();
  std::vector<WallsPtr> out(drawn.size());
  std::transform(drawn.begin(), drawn.end(), out.begin(), [](const Drawn& d) { return d.walls; });
  return out;
}

void HypothesisFinder::forget(SessionId session) {
  std::erase_if(found_, [&](const auto& f) { return f.first.first == session || f.first.second == session; });
  if (walls_.find(session)) walls_bytes_ -= walls_.drop(session).walls->bytes();
}

std::vector<Hypothesis> HypothesisFinder::search(const SessionView& a, const SessionView& b,
                                                 const SessionWalls& walls_a, const SessionWalls& walls_b,
                                                 const std::vector<MatchedPair>& matches,
                                                 const DescriptorAgreement& agreement, const LeadSeats& seats) const {
  const int threads = config_.threads;
  std::vector<Lead> leads = wall_leads(walls_a, walls_b, agreement, seats, threads);
  const std::vector<PlacedPair> placed = placed_pairs(a.keyframes, b.keyframes, matches, threads);
  for (const auto& source : {vote_leads, place_leads})
    for (const Lead& lead : source(walls_a, walls_b, b.keyframes, placed, agreement, seats, threads))
      leads.push_back(lead);
  std::vector<Hypothesis> out;
  for (const Lead& lead : leads) {
    const auto part = [](const Piece& p, std::span<const Keyframe> of) { return of.subspan(p.begin, p.end - p.begin); };
    const auto part_a = part(lead.a_on_b ? lead.part->piece : lead.a->piece, a.keyframes),
               part_b = part(lead.a_on_b ? lead.b->piece : lead.part->piece, b.keyframes);
    const bool itself = a.id == b.id;  // a copy is judged at the middle of its path: ends look alike more often
    Hypothesis h{lead.T_a_b(), lead.fit.score(), itself ? position(part_b[part_b.size() / 2]) : place_of(lead, part_b)};
    h.source = lead.source;
    h.T_a_b.translation().z() = likely_height_m(part_a, part_b, h.T_a_b, lead.height_m);
    if (std::any_of(out.begin(), out.end(),
                    [&](const auto& g) { return same_placement(g.T_a_b, h.T_a_b, h.place_b, same_hypothesis); }))
      continue;
    h.descriptors = agreement.at(h.T_a_b);
    h.promise = lead.promise;
    h.contradiction = lead.fit.contradiction();
    out.push_back(h);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Hypothesis& g, const Hypothesis& h) { return g.promise > h.promise; });
  return out;
}

const Found* HypothesisFinder::find_within(const SessionView& session) {
  LeadSeats of_walls_alone{.walls = 8,
                           .coherent = 0,
                           .places = 0,
                           .votes = 0,
                           .coarse_matches = std::min<std::size_t>(60, config_.seats.coarse_matches),
                           .steps = rough(config_.seats.steps)};
  // What the verdict demands of a mine that repeats itself was set without.
  of_walls_alone.both_orders = of_walls_alone.second_part = false;
  Found& known = found_[{session.id, session.id}];
  known = {};
  if (session.keyframes.empty()) return &known;
  const WallsPtr drawn = walls({&session, 1}).front();
  known.hypotheses = search(session, session, *drawn, *drawn, {},
                            DescriptorAgreement(session.keyframes, session.keyframes), of_walls_alone);
  return &known;
}

bool HypothesisFinder::needs_search(const SessionView& a, const SessionView& b) const {
  if (a.keyframes.empty() || b.keyframes.empty()) return false;
  const auto known = found_.find({a.id, b.id});
  if (known == found_.end() || known->second.version == 0) return true;
  return has_news(a, known->second.path_a_m) || has_news(b, known->second.path_b_m);
}

bool HypothesisFinder::has_news(const SessionView& session, double path_then_m) const {
  const double news_m = session.complete ? 1e-3 : session.asks_where ? config_.asked_news_m : config_.news_m;
  return path_m(session.keyframes) - path_then_m >= news_m;
}

std::vector<Hypothesis> HypothesisFinder::search(const SessionView& a, const SessionView& b,
                                                 const SessionWalls& walls_a, const SessionWalls& walls_b,
                                                 const LeadSeats& seats) const {
  const bool comparable = a.family == b.family;
  const DescriptorAgreement agreement(comparable ? a.keyframes : std::span<const Keyframe>(), b.keyframes);
  const auto matched =
      comparable ? match_descriptors(a.keyframes, b.keyframes, config_.threads) : std::vector<MatchedPair>();
  return search(a, b, walls_a, walls_b, matched, agreement, seats);
}

std::vector<Hypothesis> HypothesisFinder::search_apart(const SessionView& a, const SessionView& b) {
  const auto drawn = walls(std::array{a, b});
  return search(a, b, *drawn[0], *drawn[1], config_.seats);
}

std::vector<double> HypothesisFinder::promises(std::span<const std::pair<SessionView, SessionView>> pairs) {
  // More rotations and placements find hardly any other partners (tests/bench/README.md, large databases).
  LeadSeats few{.walls = 4, .coherent = 0, .places = 0, .votes = 2, .steps = rough(config_.seats.steps)};
  few.both_orders = false;
  few.coarse_matches = std::min<std::size_t>(120, config_.seats.coarse_matches);
  few.steps.quarter_turns = std::min<std::size_t>(15, few.steps.quarter_turns);
  few.steps.peaks = std::min<std::size_t>(50, few.steps.peaks);
  std::map<SessionId, SessionView> sessions;
  for (const auto& [a, b] : pairs)
    for (const SessionView& session : {a, b}) sessions.emplace(session.id, session);
  std::vector<SessionView> views(sessions.size());
  std::transform(sessions.begin(), sessions.end(), views.begin(), [](const auto& session) { return session.second; });
  const std::vector<WallsPtr> drawn = walls(views);
  std::map<SessionId, const SessionWalls*> of;
  for (std::size_t i = 0; i < views.size(); ++i) of[views[i].id] = drawn[i].get();
  std::vector<double> out(pairs.size(), 0);
  for_blocks(pairs.size(), 1, config_.threads, [&](std::size_t i, std::size_t, std::size_t) {
    const auto& [a, b] = pairs[i];
    const auto found = search(a, b, *of.at(a.id), *of.at(b.id), few);
    for (const Hypothesis& h : found) out[i] = std::max(out[i], h.promise * std::pow(2 * h.descriptors.cautious(), 2));
  });
  return out;
}

const Found* HypothesisFinder::take(const SessionView& a, const SessionView& b, std::vector<Hypothesis> hypotheses) {
  if (allowed_ == 0) return nullptr;
  --allowed_;
  Found& known = found_[{a.id, b.id}];
  known = {known.version + 1, std::move(hypotheses), path_m(a.keyframes), path_m(b.keyframes)};
  return &known;
}

const Found* HypothesisFinder::find(const SessionView& a, const SessionView& b) {
  if (!needs_search(a, b)) return &found_[{a.id, b.id}];
  if (allowed_ == 0) return nullptr;
  return take(a, b, search_apart(a, b));
}

}  // namespace headframe
