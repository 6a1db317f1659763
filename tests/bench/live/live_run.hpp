#pragma once
// Robots that drive while a server merges, in process and by a clock of its own. The pipeline and its schedule are the
// product's; what an attempt takes is drawn, so that the same conditions always give the same run.

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "server/merge/merge_pipeline.hpp"
#include "server/merge_worker/merge_schedule.hpp"
#include "tests/bench/pipeline_run.hpp"
#include "tests/mine/random.hpp"

namespace headframe::bench {

enum class Start { together, one_after_another, last_joins_midway };

/// How robots drive and what the server has to cope with.
struct LiveConditions {
  double rate = 1;      // times real time; in real time robots drive 1 m/s
  double slowness = 1;  // attempts take so many times as long as on idle cores
  Start start = Start::together;
  Clouds clouds = Clouds::at_once;
  bool loses_link = false;  // the last robot, for the middle third of its drive
  bool restarts = false;    // the server, when two thirds are told
  std::uint64_t seed = 1;   // of the order of the robots, and of what attempts take
};

/// A session as far as the server knows it.
struct LiveSession {
  const DrivenSession* driven = nullptr;
  std::size_t told = 0;      // keyframes
  double path_m = 0;         // to the last of them
  std::size_t tried = 0;     // keyframes that the last finished attempt used
  bool tried_whole = false;  // ... and the session had then ended
  bool complete = false;
  bool connected = false;
};

class LiveRun : private CloudSource {
 public:
  /// Told whenever attempts changed something, with the pipeline as it is then.
  using Watch = std::function<void(const LiveRun&)>;

  /// `present` are complete from the start; `driving` are driven under the conditions. All must outlive the run.
  LiveRun(const std::vector<const DrivenSession*>& present, const std::vector<const DrivenSession*>& driving,
          const LiveConditions& conditions, Watch watch);

  /// Until every robot has said goodbye and nothing is left to try.
  void drive();
  /// The operator asks for a merge of all; until nothing is left to try.
  void ask_for_merges();

  const MergePipeline& pipeline() const { return *pipeline_; }
  const std::map<SessionId, LiveSession>& sessions() const { return sessions_; }
  double now_s() const { return now_s_; }
  std::size_t attempts() const { return attempts_; }

 private:
  CloudState state(const KeyframeRef& keyframe) const override;
  Result<CloudDecoder> load(const KeyframeRef& keyframe) override;

  SessionId add(const DrivenSession& driven);
  void plan_drive(SessionId id, double start_s, bool loses_link);
  void at(double time_s, std::function<void()> what) { events_.emplace(time_s, std::move(what)); }
  void tell_keyframe(SessionId id);
  void lose_link(SessionId id);
  void find_link(SessionId id);
  void say_goodbye(SessionId id);
  void restart();
  void settle();
  bool step();
  void attempt(const MergeSchedule::Attempt& attempt);
  void request(const std::vector<KeyframeRef>& clouds);
  double effort_s(double idle_s);
  MergeSchedule::Time time() const;

  LiveConditions conditions_;
  Watch watch_;
  std::unique_ptr<MergePipeline> pipeline_;
  std::unique_ptr<MergeSchedule> schedule_;
  std::map<SessionId, LiveSession> sessions_;
  std::multimap<double, std::function<void()>> events_;
  std::set<KeyframeRef> came_;
  mine::Rng rng_;
  double now_s_ = 0;
  std::size_t attempts_ = 0;
};

}  // namespace headframe::bench
