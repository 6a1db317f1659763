#pragma once
// What the merge pipeline keeps, and the details that its page (merge_pipeline.cpp) leaves out.

#include <chrono>
#include <map>
#include <numbers>

#include "common/descriptor/family.hpp"
#include "server/merge_pipeline.hpp"
#include "server/place/hypotheses.hpp"
#include "server/prepared_clouds.hpp"
#include "server/registration/verification.hpp"

namespace headframe {

/// How often a session looks like itself elsewhere, and at which length of its path that was found.
struct SelfLikeness {
  double path_m = -1;
  double aliases = 0;
};

struct Session {
  FamilyId family;
  std::vector<Keyframe> keyframes;
  double path_m = 0;
  bool complete = false;
  SelfLikeness self;
};

struct Family {
  std::unique_ptr<DescriptorFamily> compare;  // null: not known here; wall maps still work
  std::unique_ptr<DescriptorIndex> index;
};

/// A hypothesis with the clouds that can speak on it.
struct Case {
  Hypothesis hypothesis;
  std::vector<PlacedCloud> a, b;
  std::vector<KeyframeRef> missing;  // can be had and are needed, the nearest first
};

/// A hypothesis as it was judged; with rivals the runner-up can be told.
struct Verdict {
  Judgement judgement;
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();  // where the placement was registered first, in b's frame
};

struct MergePipeline::State {
  MergeConfig config;
  std::map<SessionId, Session> sessions;
  std::map<FamilyId, Family> families;
  std::vector<Alignment> alignments;
  DecisionBook decisions;
  std::vector<SessionId> anchors;  // in the order they were chosen
  Atlas atlas;
  HypothesisFinder finder;
  PreparedClouds prepared;
  /// What a pair was judged on last: it is judged again only when there is more.
  std::map<std::pair<SessionId, SessionId>, std::vector<std::size_t>> judged_on;

  explicit State(const MergeConfig& c);

  void merge_pair(SessionId a, SessionId b, CloudSource& clouds, AttemptReport& report);
  bool still_holds(Alignment& published, CloudSource& clouds, AttemptReport& report);
  void record(SessionId a, SessionId b, const Judgement& best, const std::optional<Pose>& T_a_b_runner_up,
              AttemptReport& report);
  void update_atlas(AttemptReport& report);

  /// Sessions of the same family, those whose descriptors look most alike first.
  std::vector<SessionId> partners(SessionId id) const;
  std::vector<MatchedPair> match_descriptors(SessionId a, SessionId b) const;
  Case make_case(SessionId a, SessionId b, const Hypothesis& hypothesis, CloudSource& clouds);
  /// Placements of a session on itself, other than where it lies, whose first place looks right: its mine repeats
  /// itself. Looked for again when the session has grown by a quarter.
  double self_aliases(SessionId id, CloudSource& clouds);
  /// Glances at all, in parallel; the hopeful ones that differ are judged. Best first.
  std::vector<Verdict> judge_cases(const std::vector<Case>& cases, double self_aliases, AttemptReport& report) const;
  Alignment* find(SessionId a, SessionId b);
  void index_keyframe(SessionId id, const Keyframe& keyframe);
  /// A few metres of drift look like many others: a growing session waits until it has seen more.
  bool may_merge(SessionId id) { return sessions[id].complete || sessions[id].path_m >= config.least_path_m; }
  JudgeConfig judge_config() const;

 private:
  std::vector<PlacedCloud> clouds_near(SessionId id, SessionId other, const Pose& T_id_other, CloudSource& clouds,
                                       std::vector<KeyframeRef>& missing);
};

/// Adds the time of a scope to a total.
class Stopwatch {
 public:
  explicit Stopwatch(double& total_ms) : total_ms_(total_ms), start_(Clock::now()) {}
  ~Stopwatch() { total_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  double& total_ms_;
  Clock::time_point start_;
};

/// Whether two placements put p more than so many metres, or turn more than so many radians, apart.
inline bool differ(const Pose& T, const Pose& U, const Eigen::Vector3d& p, double metres, double radians) {
  return (T * p - U * p).norm() > metres || rotation_angle_rad(T.inverse() * U) > radians;
}

}  // namespace headframe
