#include "server/place/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/descriptor/circular.hpp"
#include "server/place/descriptor_agreement.hpp"
#include "server/registration/parallel.hpp"

namespace headframe {
namespace {

constexpr std::size_t pairs_tried = 128, proposals = 6;
constexpr double same_m = 4, same_rad = 0.26;  // 15 deg

Eigen::Vector3d place(const Keyframe& keyframe) { return keyframe.T_local_sensor.translation(); }

/// Height of b's frame in a's, from the two keyframes that the placement brings nearest to each other.
double height_m(std::span<const Keyframe> a, std::span<const Keyframe> b, const Pose& T_a_b) {
  double nearest = std::numeric_limits<double>::max(), height = 0;
  for (const Keyframe& k : b) {
    const Eigen::Vector3d p = T_a_b * place(k);
    for (const Keyframe& l : a) {
      const Eigen::Vector3d d = place(l) - p;
      if (d.head<2>().squaredNorm() >= nearest) continue;
      nearest = d.head<2>().squaredNorm();
      height = d.z();
    }
  }
  return height;
}

bool same(const Pose& T, const Pose& U, const Eigen::Vector3d& at) {
  return (T * at - U * at).norm() < same_m && std::abs(wrap_rad(yaw_rad(T) - yaw_rad(U))) < same_rad;
}

/// Placements that the descriptors propose: those of single matched pairs, the rarest and nearest first, that bring the
/// most keyframes together whose descriptors agree. The best of each kind only.
std::vector<Pose> from_descriptors(std::span<const Keyframe> a, std::span<const Keyframe> b,
                                   std::vector<MatchedPair> matches, const DescriptorAgreement& agreement,
                                   int threads) {
  std::vector<float> popular(a.size(), 0);
  for (const MatchedPair& m : matches) ++popular[m.a];
  std::stable_sort(matches.begin(), matches.end(), [&](const auto& m, const auto& n) {
    return m.squared_distance * popular[m.a] < n.squared_distance * popular[n.a];
  });
  if (matches.size() > pairs_tried) matches.resize(pairs_tried);
  struct Candidate {
    Pose T;
    Eigen::Vector3d at;
    double support = 0;
  };
  std::vector<Candidate> candidates;
  for (const MatchedPair& m : matches)
    for (const Pose& T : initial_transforms(a[m.a], b[m.b], 2)) candidates.push_back({T, place(b[m.b])});
  for_blocks(candidates.size(), 1, threads, [&](std::size_t i, std::size_t, std::size_t) {
    candidates[i].support = agreement.at(candidates[i].T).support();
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& c, const Candidate& d) { return c.support > d.support; });
  std::vector<Pose> found;
  for (const Candidate& c : candidates) {
    if (found.size() == proposals) break;
    if (std::none_of(found.begin(), found.end(), [&](const Pose& T) { return same(T, c.T, c.at); }))
      found.push_back(c.T);
  }
  return found;
}

/// A placement, and the part of b that bears it best.
struct Lead {
  const SessionWalls::Level* a = nullptr;
  const SessionWalls::Part* part = nullptr;
  WallMatch match;
  bool trusted = false;  // the descriptors speak for it: stays whatever the walls say
  double promise = 0;
};

/// Squared: of two that fit the walls, the descriptors' agreement is the better judge.
double promise(double score, const Agreement& agreement) {
  return std::max(0.0, score) * agreement.cautious() * agreement.cautious();
}

Lead best_part(const SessionWalls::Level& a, const SessionWalls::Level& b, const WallMatch& match) {
  Lead best{&a, nullptr, match, false};
  best.match.score = std::numeric_limits<double>::lowest();
  for (const auto& part : b.parts)
    if (const double s = a.field.score(part.map, match); s > best.match.score) {
      best.part = &part;
      best.match.score = s;
    }
  return best;
}

Pose placement(const WallMatch& m) { return pose_from_yaw(m.yaw_rad, {m.shift_m.x(), m.shift_m.y(), 0}); }

/// Where b's level could lie on a's. A long one is laid piece by piece: over hundreds of metres half a step of a turn,
/// and drift, put a right placement's ends off the walls.
void search_level(const SessionWalls::Level& a, const SessionWalls::Level& b, const HypothesisFinder::Config& config,
                  std::vector<Lead>& leads) {
  constexpr std::size_t laid_whole = 5;  // pieces: 360 m of path
  if (b.parts.size() <= laid_whole) {
    for (const WallMatch& m : search_walls(a.map, a.field, b.map, config.refined, config.threads))
      leads.push_back(best_part(a, b, m));
    return;
  }
  for (const auto& part : b.parts)
    for (const WallMatch& m : search_walls(a.map, a.field, part.map, config.refined, config.threads))
      leads.push_back({&a, &part, m, false});
}

/// The levels of both sessions on each other, and the descriptors' transforms on every level they fit: refined by the
/// walls, a few metres first, then the best to half a cell.
std::vector<Lead> leads_of(const SessionWalls& a, const SessionWalls& b, std::span<const Pose> proposed,
                           const DescriptorAgreement& agreement, const HypothesisFinder::Config& config) {
  std::vector<Lead> leads;
  for (const auto& level_a : a.levels)
    for (const auto& level_b : b.levels) {
      search_level(level_a, level_b, config, leads);
      for (std::size_t i = 0; i < proposed.size(); ++i) {
        const Pose& T = proposed[i];
        leads.push_back(best_part(level_a, level_b, {yaw_rad(T), T.translation().head<2>(), 0}));
        leads.back().trusted = i < config.trusted;
      }
    }
  std::erase_if(leads, [](const Lead& l) { return l.part == nullptr; });
  const auto refine = [&](WallField::Step step) {
    for_blocks(leads.size(), 1, config.threads, [&](std::size_t i, std::size_t, std::size_t) {
      Lead& lead = leads[i];
      // What the descriptors propose may fit the walls nowhere near: then it stays, instead of going where none are.
      const WallMatch refined = lead.a->field.refine(lead.part->map, lead.match, step);
      if (refined.score > 0) lead.match = refined;
      lead.promise = promise(lead.match.score, agreement.at(placement(lead.match), Heights::any));
    });
    std::stable_sort(leads.begin(), leads.end(), [](const Lead& l, const Lead& m) { return l.promise > m.promise; });
  };
  refine(WallField::Step::coarse);
  std::size_t kept = 0;
  std::erase_if(leads, [&](const Lead& l) { return kept++ >= config.fine && !l.trusted; });
  refine(WallField::Step::fine);
  return leads;
}

}  // namespace

std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, std::size_t most_yaws) {
  std::vector<Pose> out;
  for (const YawScore& yaw : correlate_circular(a.descriptor.w, b.descriptor.w, most_yaws))
    out.push_back(levelled(a.T_local_sensor) * pose_from_yaw(yaw.yaw_rad, Eigen::Vector3d::Zero()) *
                  levelled(b.T_local_sensor).inverse());
  return out;
}

std::shared_ptr<const SessionWalls> HypothesisFinder::walls(const SessionView& session) {
  if (const auto* known = walls_.find(session.id)) {
    if ((*known)->path_m == path_m(session.keyframes)) return *known;
    walls_bytes_ -= walls_.drop(session.id)->bytes();
  }
  auto drawn = std::make_shared<const SessionWalls>(session.keyframes);
  walls_.put(session.id, drawn);
  walls_bytes_ += drawn->bytes();
  while (walls_bytes_ > config_.walls_bytes && walls_.size() > 1) walls_bytes_ -= walls_.drop_oldest()->bytes();
  return drawn;
}

std::vector<Hypothesis> HypothesisFinder::search(const SessionView& a, const SessionView& b,
                                                 const std::vector<Pose>& proposed,
                                                 const DescriptorAgreement& agreement) {
  const auto walls_a = walls(a), walls_b = walls(b);
  std::vector<Hypothesis> out;
  for (const Lead& lead : leads_of(*walls_a, *walls_b, proposed, agreement, config_)) {
    if (out.size() >= config_.most && !lead.trusted) continue;
    const Piece piece_a = lead.a->piece, piece_b = lead.part->piece;
    Hypothesis h{placement(lead.match), lead.match.score, place(b.keyframes[(piece_b.begin + piece_b.end) / 2])};
    h.T_a_b.translation().z() = height_m(a.keyframes.subspan(piece_a.begin, piece_a.end - piece_a.begin),
                                         b.keyframes.subspan(piece_b.begin, piece_b.end - piece_b.begin), h.T_a_b);
    if (std::any_of(out.begin(), out.end(), [&](const auto& g) { return same(g.T_a_b, h.T_a_b, h.place_b); })) continue;
    h.descriptors = agreement.at(h.T_a_b);
    out.push_back(h);
  }
  std::stable_sort(out.begin(), out.end(), [](const Hypothesis& g, const Hypothesis& h) {
    return promise(g.score, g.descriptors) > promise(h.score, h.descriptors);
  });
  return out;
}

const Found* HypothesisFinder::find_within(const SessionView& session) {
  Found& known = found_[{session.id, session.id}];
  known = {};
  if (!session.keyframes.empty())
    known.hypotheses = search(session, session, {}, DescriptorAgreement(session.keyframes, session.keyframes));
  return &known;
}

const Found* HypothesisFinder::find(const SessionView& a, const SessionView& b,
                                    const std::function<std::vector<MatchedPair>()>& matches) {
  Found& known = found_[{a.id, b.id}];
  const double path_a = path_m(a.keyframes), path_b = path_m(b.keyframes);
  const bool grown = path_a - known.path_a_m >= config_.news_m || path_b - known.path_b_m >= config_.news_m;
  if (known.version > 0 && !grown) return &known;
  if (a.keyframes.empty() || b.keyframes.empty()) return &known;
  if (allowed_ == 0) return nullptr;
  --allowed_;
  const DescriptorAgreement agreement(a.keyframes, b.keyframes);
  std::vector<Pose> proposed;
  if (const auto matched = matches(); !matched.empty())
    proposed = from_descriptors(a.keyframes, b.keyframes, matched, agreement, config_.threads);
  known = {known.version + 1, search(a, b, proposed, agreement), path_a, path_b};
  return &known;
}

}  // namespace headframe
