#include "server/station/cloud_keeping.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "server/surroundings/seen_rock.hpp"

namespace headframe {
namespace {

struct Placed {
  std::uint64_t sequence = 0;
  Pose T_component_sensor = Pose::Identity();
  WallProfile walls;
};

std::set<SessionId> keep_all(const KeptSessions& known) {
  std::set<SessionId> kept, growing;
  for (const SessionRow& row : known.rows) {
    if (!row.complete) growing.insert(row.id);
    if (!row.complete || row.frozen || row.archived || !row.why_aside.empty()) kept.insert(row.id);
  }
  for (const Alignment& k : known.alignments) {  // the evidence of these pairs may still be needed
    if (k.state == AlignmentState::rejected) continue;
    if (growing.contains(k.a)) kept.insert(k.b);
    if (growing.contains(k.b)) kept.insert(k.a);
  }
  return kept;
}

/// The keyframes whose clouds are stored, with their places in the component.
Result<std::vector<Placed>> placed_keyframes(Store& store, const Placement& placement, const Corrections& corrections,
                                             const std::map<std::uint64_t, std::uint64_t>& stored) {
  std::vector<Placed> placed;
  const auto bent = corrections.find(placement.session);
  const auto read = store.each_keyframe(placement.session, 1, [&](const Keyframe& k) {
    if (!stored.contains(k.sequence)) return;
    const Pose T = bent == corrections.end() ? placement.T_component_session * k.T_local_sensor
                                             : bent->second->corrected(k.sequence, k.T_local_sensor);
    placed.push_back({k.sequence, T, k.walls});
  });
  if (!read) return tl::unexpected(read.error());
  return placed;
}

/// Adds what may be deleted of one component. The newest session comes first, as only clouds that stay cover earlier
/// ones.
Result<void> add_covered(Store& store, const KeptSessions& known, const Component& component,
                         const std::set<SessionId>& kept, std::vector<CoveredClouds>& out) {
  std::map<SessionId, const SessionRow*> rows;
  for (const SessionRow& row : known.rows) rows[row.id] = &row;
  std::vector<Placement> newest_first = component.placements;
  std::sort(newest_first.begin(), newest_first.end(),
            [](const Placement& p, const Placement& q) { return p.session > q.session; });
  SeenRock seen;
  for (const Placement& placement : newest_first) {
    const auto row = rows.find(placement.session);
    if (row == rows.end() || row->second->archived || !row->second->why_aside.empty()) continue;
    const auto sizes = store.cloud_sizes(placement.session);
    if (!sizes) return tl::unexpected(sizes.error());
    std::map<std::uint64_t, std::uint64_t> stored;
    for (const CloudSize& cloud : *sizes) stored[cloud.sequence] = cloud.bytes;
    const auto keyframes = placed_keyframes(store, placement, known.corrections, stored);
    if (!keyframes) return tl::unexpected(keyframes.error());
    CoveredClouds of{placement.session, {}, 0, stored.size()};
    std::vector<const Placed*> staying;
    for (const Placed& k : *keyframes) {
      const auto share = seen.share_seen(k.T_component_sensor, k.walls);
      const bool goes = !kept.contains(placement.session) && share && *share >= covered_share;
      if (!goes) staying.push_back(&k);
      if (!goes) continue;
      of.clouds.push_back({k.sequence, stored[k.sequence]});
      of.bytes += stored[k.sequence];
    }
    if (row->second->complete)
      for (const Placed* k : staying) seen.add(k->T_component_sensor, k->walls);
    if (!of.clouds.empty()) out.push_back(std::move(of));
  }
  return {};
}

constexpr std::size_t portion = 128;  // clouds deleted in one commit

struct Portions : std::enable_shared_from_this<Portions> {
  Portions(Store& where, LettingGo whom) : store(where), told(std::move(whom)) {}

  void next() {
    if (at == portions.size()) return told.done({});
    store.write(portions[at], [self = shared_from_this()](const Result<void>& done) {
      if (!done) return self->told.done(done);
      std::vector<std::uint64_t> sequences;
      for (const KeyframeRef& cloud : self->portions[self->at].clouds) sequences.push_back(cloud.sequence);
      self->told.gone(self->portions[self->at].clouds.front().session, sequences);
      ++self->at;
      self->next();
    });
  }

  Store& store;
  LettingGo told;
  std::vector<LetGo> portions;  // each of one session
  std::size_t at = 0;
};

}  // namespace

Result<std::vector<CoveredClouds>> covered_clouds(Store& store, const KeptSessions& known) {
  const std::set<SessionId> kept = keep_all(known);
  std::vector<CoveredClouds> out;
  for (const Component& component : known.atlas.components)
    if (component.placements.size() > 1)
      if (auto done = add_covered(store, known, component, kept, out); !done) return tl::unexpected(done.error());
  std::sort(out.begin(), out.end(),
            [](const CoveredClouds& a, const CoveredClouds& b) { return a.session < b.session; });
  return out;
}

void let_go(Store& store, const std::vector<CoveredClouds>& clouds, LettingGo told) {
  const auto portions = std::make_shared<Portions>(store, std::move(told));
  for (const CoveredClouds& of : clouds)
    for (std::size_t i = 0; i < of.clouds.size(); ++i) {
      if (i % portion == 0) portions->portions.emplace_back();
      portions->portions.back().clouds.push_back({of.session, of.clouds[i].sequence});
    }
  portions->next();
}

}  // namespace headframe
