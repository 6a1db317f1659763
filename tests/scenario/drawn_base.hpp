#pragma once
// A merge pipeline with drawn drives in it, without sockets or disk.

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "common/descriptor/scan_context.hpp"
#include "server/merge/merge_pipeline.hpp"
#include "tests/support/drawn_session.hpp"

namespace headframe::test {

class Shelf : public CloudSource {
 public:
  std::map<KeyframeRef, KeyframeCloud> clouds;
  std::set<KeyframeRef> on_robots;
  CloudState state(const KeyframeRef& k) const override {
    if (on_robots.contains(k)) return CloudState::obtainable;
    return clouds.contains(k) ? CloudState::stored : CloudState::unobtainable;
  }
  Result<CloudDecoder> load(const KeyframeRef& k) override {
    return [&cloud = clouds.at(k)]() -> Result<KeyframeCloud> { return cloud; };
  }
};

/// Of two drives through a drawn mine of boxes, where one place looks like another, without waiting for third sessions.
inline MergeConfig waits_for_no_others() {
  MergeConfig config;
  config.look_alikes = 1e9;
  return config;
}

/// A pipeline with these drives in it as sessions 1, 2, ...
struct Base {
  MergePipeline pipeline;
  Shelf shelf;
  std::vector<Drive> drives;

  explicit Base(const std::vector<Drive>& all, const MergeConfig& config = waits_for_no_others(),
                PairHelpers* helpers = nullptr)
      : pipeline(config, helpers) {
    for (const Drive& drive : all) arrive(drive);
  }

  SessionId arrive(const Drive& drive, const FamilyId& family = ScanContext().id()) {
    const SessionId id = grow(drive, family);
    pipeline.complete_session(id);
    return id;
  }

  /// Its robot may drive on.
  SessionId grow(const Drive& drive, const FamilyId& family = ScanContext().id()) {
    drives.push_back(drive);
    const auto id = static_cast<SessionId>(drives.size());
    pipeline.add_session(id, family);
    for (std::size_t k = 0; k < drive.keyframes.size(); ++k) {
      pipeline.add_keyframe(id, drive.keyframes[k]);
      shelf.clouds[{id, k + 1}] = drive.clouds[k];
    }
    return id;
  }

  double error_m() const {
    double worst = 0;
    for (const Component& c : pipeline.atlas().components)
      for (const Placement& p : c.placements) {
        const Pose truth = drive(c.id).T_mine_local.inverse() * drive(p.session).T_mine_local;
        worst = std::max(worst, (truth.translation() - p.T_component_session.translation()).norm());
      }
    return worst;
  }
  const Drive& drive(SessionId id) const { return drives[static_cast<std::size_t>(id - 1)]; }
};

}  // namespace headframe::test
