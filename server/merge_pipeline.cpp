#include "server/merge_pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>

#include "common/descriptor/family.hpp"
#include "server/atlas/merge_graph.hpp"
#include "server/place/hypotheses.hpp"
#include "server/prepared_clouds.hpp"
#include "server/registration/verification.hpp"

namespace headframe {
namespace {

constexpr std::size_t neighbours = 5;          // of each keyframe, in the votes
constexpr std::size_t exact_up_to = 20000;     // keyframes of a family; FLANN beyond
constexpr std::size_t hypotheses_awaited = 2;  // that may wait for clouds at a time
constexpr double rival_share = 0.7;            // of the support: weaker rivals of an accepted one ask for no clouds
constexpr double news_m = 0.05, news_rad = 0.2 * std::numbers::pi / 180;  // smaller changes of a transform are not told

struct Session {
  FamilyId family;
  std::vector<Keyframe> keyframes;
  double path_m = 0;
  bool complete = false;
};

struct Family {
  std::unique_ptr<DescriptorFamily> compare;  // null: not known here; wall maps still work
  std::unique_ptr<DescriptorIndex> index;
};

/// A hypothesis that was judged, and on how many clouds: judged again only when there are more.
struct Judged {
  Pose T_0;
  std::size_t clouds = 0;
  Judgement result;
};

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

bool differ(const Pose& T, const Pose& U, double metres, double radians) {
  const Pose error = T.inverse() * U;
  return error.translation().norm() > metres || rotation_angle_rad(error) > radians;
}

}  // namespace

struct MergePipeline::State {
  MergeConfig config;
  std::map<SessionId, Session> sessions;
  std::map<FamilyId, Family> families;
  std::vector<Alignment> alignments;
  DecisionBook decisions;
  Atlas atlas;
  HypothesisFinder finder;
  PreparedClouds prepared;
  std::map<std::pair<SessionId, SessionId>, std::vector<Judged>> judged;

  explicit State(const MergeConfig& c)
      : config(c),
        finder({.most = static_cast<std::size_t>(c.hypotheses),
                .correlations = static_cast<std::size_t>(c.correlations),
                .threads = c.threads}),
        prepared(static_cast<std::size_t>(c.clouds_kept)) {}

  void merge_pair(SessionId a, SessionId b, CloudSource& clouds, AttemptReport& report);
  bool still_holds(Alignment& published, CloudSource& clouds, AttemptReport& report);
  std::vector<MatchedPair> match_descriptors(SessionId a, SessionId b);
  std::vector<PlacedCloud> clouds_near(SessionId id, SessionId other, const Pose& T_id_other, CloudSource& clouds,
                                       std::vector<KeyframeRef>& missing);
  const Judged& judge_once(SessionId a, SessionId b, const Pose& T_0, std::span<const PlacedCloud> clouds_a,
                           std::span<const PlacedCloud> clouds_b, AttemptReport& report);
  void record(SessionId a, SessionId b, const Judgement& best, AttemptReport& report);
  void update_atlas(AttemptReport& report);
  Alignment* find(SessionId a, SessionId b);
  void move_to_flann(const FamilyId& id, std::size_t q_size);
  /// A few metres of drift look like many others: a growing session waits until it has seen more.
  bool may_merge(SessionId id) { return sessions[id].complete || sessions[id].path_m >= config.least_path_m; }
};

// ---- The page: one attempt to merge one session with all others (FRAME, section on map merging; numbers of its steps)

AttemptReport MergePipeline::attempt(SessionId id, CloudSource& clouds) {
  AttemptReport report;
  const auto self = state_->sessions.find(id);
  if (self == state_->sessions.end()) return report;
  for (const auto& [other, session] : state_->sessions)
    if (other != id && session.family == self->second.family)
      state_->merge_pair(std::min(id, other), std::max(id, other), clouds, report);
  state_->update_atlas(report);  // 9: maps merge one after another
  return report;
}

void MergePipeline::State::merge_pair(SessionId a, SessionId b, CloudSource& clouds, AttemptReport& report) {
  Alignment* known = find(a, b);
  const bool in_force = known && (known->state == AlignmentState::published || known->ruling == Ruling::confirmed);
  if (in_force && still_holds(*known, clouds, report)) return;

  // 5, 6: where could b lie on a? Not one nearest pair, but all that the descriptors and the wall maps propose.
  std::vector<Hypothesis> hypotheses;
  {
    const Stopwatch watch(report.times.hypotheses_ms);
    bool exhausted = true;
    hypotheses = finder.find(a, sessions[a].keyframes, b, sessions[b].keyframes, match_descriptors(a, b),
                             families[sessions[a].family].compare.get(), exhausted);
    report.unfinished |= !exhausted;
  }
  // 7, 8: the spheres and their registration, then what the paper lacks: evidence, and a runner-up.
  Judgement best;
  std::vector<std::pair<Pose, double>> rivals;
  std::size_t awaited = 0;
  for (const Hypothesis& h : hypotheses) {
    std::vector<KeyframeRef> missing;
    std::vector<PlacedCloud> clouds_a, clouds_b;
    {
      const Stopwatch watch(report.times.sampling_ms);
      clouds_a = clouds_near(a, b, h.T_a_b, clouds, missing);
      clouds_b = clouds_near(b, a, h.T_a_b.inverse(), clouds, missing);
    }
    const bool weak_rival =
        best.evidence.probability >= config.accept_probability && h.score < rival_share * best.evidence.support;
    if (!missing.empty() && awaited < hypotheses_awaited && !weak_rival) {
      ++awaited;
      report.wanted.insert(report.wanted.end(), missing.begin(), missing.end());
      continue;
    }
    Judgement judgement = judge_once(a, b, h.T_a_b, clouds_a, clouds_b, report).result;
    judgement.evidence.support = h.score;
    if (known && decisions.proposal(known->id, judgement.T_a_b, judgement.evidence.seen_points) == Proposal::suppressed)
      continue;
    rivals.emplace_back(judgement.T_a_b, judgement.evidence.probability);
    if (rivals.size() == 1 || judgement.evidence.probability > best.evidence.probability) best = judgement;
  }
  for (const auto& [T, p] : rivals)
    if (differ(T, best.T_a_b, 2.0, 0.17)) best.evidence.runner_up = std::max(best.evidence.runner_up, p);
  if (!rivals.empty() && (awaited == 0 || best.evidence.probability < config.accept_probability))
    record(a, b, best, report);
}

/// A published alignment is looked at again with the keyframes that came since. False: it does not stand up any more;
/// one that the operator confirmed always does.
bool MergePipeline::State::still_holds(Alignment& published, CloudSource& clouds, AttemptReport& report) {
  std::vector<KeyframeRef> missing;  // not asked for: the merge stands, more clouds may come in the background
  const auto clouds_a = clouds_near(published.a, published.b, published.T_a_b, clouds, missing);
  const auto clouds_b = clouds_near(published.b, published.a, published.T_a_b.inverse(), clouds, missing);
  if (clouds_a.empty() || clouds_b.empty()) return true;
  auto& memory = judged[{published.a, published.b}];
  const std::size_t count = clouds_a.size() + clouds_b.size();
  for (const Judged& j : memory)
    if (j.clouds == count && !differ(j.T_0, published.T_a_b, 1e-9, 1e-9)) return true;
  const Stopwatch watch(report.times.verification_ms);
  const JudgeConfig judge_config{.threads = config.threads};
  const Judgement again = judge_again(clouds_a, clouds_b, published.T_a_b, judge_config);
  if (again.evidence.probability < config.candidate_probability) return published.ruling == Ruling::confirmed;
  if (again.evidence.probability >= config.accept_probability &&
      differ(again.T_a_b, published.T_a_b, news_m, news_rad)) {
    const double support = published.evidence.support, runner_up = published.evidence.runner_up;
    published.T_a_b = again.T_a_b;
    published.evidence = again.evidence;
    published.evidence.support = support;
    published.evidence.runner_up = runner_up;
    report.changed.push_back(published);
  }
  memory.assign(1, {published.T_a_b, count, again});
  return true;
}

void MergePipeline::State::record(SessionId a, SessionId b, const Judgement& best, AttemptReport& report) {
  const Evidence& e = best.evidence;
  AlignmentState now = AlignmentState::rejected;
  if (e.probability >= config.accept_probability && e.runner_up < config.runner_up_probability)
    now = may_merge(a) && may_merge(b) ? AlignmentState::verified : AlignmentState::candidate;
  else if (e.probability >= config.candidate_probability)
    now = AlignmentState::candidate;
  Alignment* known = find(a, b);
  if (!known) {
    alignments.push_back({static_cast<AlignmentId>(alignments.size()) + 1, a, b, now, best.T_a_b, e, now});
    report.changed.push_back(alignments.back());
    return;
  }
  // What the operator ruled on stays in sight until something better than nothing turns up.
  if (known->ruling != Ruling::none && now == AlignmentState::rejected) return;
  const bool refused_once = decisions.proposal(known->id, best.T_a_b, e.seen_points) == Proposal::as_candidate;
  if (refused_once && now == AlignmentState::verified) now = AlignmentState::candidate;
  known->verdict = now;
  if (known->state == AlignmentState::published && now != AlignmentState::verified) now = AlignmentState::retracted;
  if (known->state == AlignmentState::retracted && now == AlignmentState::rejected) now = AlignmentState::retracted;
  const bool news = known->state != now || differ(known->T_a_b, best.T_a_b, 1e-6, 1e-6);
  known->state = now;
  known->T_a_b = best.T_a_b;
  known->evidence = e;
  known->ruling = decisions.ruling(*known);
  if (news) report.changed.push_back(*known);
}

void MergePipeline::State::update_atlas(AttemptReport& report) {
  const Stopwatch watch(report.times.atlas_ms);
  std::vector<SessionId> ids;
  for (const auto& [id, session] : sessions) ids.push_back(id);
  const MergeResult merged = merge_sessions(ids, alignments);
  for (std::size_t i = 0; i < alignments.size(); ++i) {
    if (alignments[i].state == merged.states[i]) continue;
    alignments[i].state = merged.states[i];
    report.changed.push_back(alignments[i]);
  }
  // The last word on an alignment is the one to be stored.
  std::map<AlignmentId, Alignment> last;
  for (const Alignment& alignment : report.changed) last[alignment.id] = alignment;
  report.changed.clear();
  for (auto& [id, alignment] : last) report.changed.push_back(*find(alignment.a, alignment.b));

  std::map<SessionId, std::pair<SessionId, Pose>> before;
  for (const Component& component : atlas.components)
    for (const Placement& p : component.placements) before[p.session] = {component.id, p.T_component_session};
  for (const Component& component : merged.components)
    for (const Placement& p : component.placements) {
      const auto was = before.find(p.session);
      const bool alone = was == before.end() && component.placements.size() == 1;  // a new session moves no transform
      if (alone) continue;
      report.atlas_changed |= was == before.end() || was->second.first != component.id ||
                              differ(was->second.second, p.T_component_session, 1e-6, 1e-6);
    }
  atlas.components = merged.components;
  if (report.atlas_changed) ++atlas.revision;
}

// ---- Details

std::vector<MatchedPair> MergePipeline::State::match_descriptors(SessionId a, SessionId b) {
  std::vector<MatchedPair> matches;
  const Family& family = families[sessions[a].family];
  if (!family.index) return matches;
  const std::size_t asked = neighbours * std::max<std::size_t>(2, sessions.size());
  for (std::size_t j = 0; j < sessions[b].keyframes.size(); ++j) {
    std::size_t taken = 0;
    for (const PlaceNeighbour& n : family.index->nearest(sessions[b].keyframes[j].descriptor.q, asked)) {
      if (n.keyframe.session != a || taken == neighbours) continue;
      ++taken;
      matches.push_back({static_cast<std::size_t>(n.keyframe.sequence - 1), j, n.squared_distance});
    }
  }
  return matches;
}

/// Clouds of `id` that lie within reach of the other session; what is missing of them and can be had is listed, the
/// nearest first.
std::vector<PlacedCloud> MergePipeline::State::clouds_near(SessionId id, SessionId other, const Pose& T_id_other,
                                                           CloudSource& clouds, std::vector<KeyframeRef>& missing) {
  const double reach_m = JudgeConfig{}.look_m, needed_m = JudgeConfig{}.meet_m;
  std::vector<PlacedCloud> near;
  std::vector<std::pair<double, KeyframeRef>> absent;
  for (const Keyframe& k : sessions[id].keyframes) {
    double distance = reach_m;
    for (const Keyframe& l : sessions[other].keyframes)
      distance =
          std::min(distance, (k.T_local_sensor.translation() - T_id_other * l.T_local_sensor.translation()).norm());
    if (distance >= reach_m || k.point_count == 0) continue;
    const KeyframeRef ref{id, k.sequence};
    if (auto cloud = prepared.get(ref, clouds))
      near.push_back({k.sequence, k.T_local_sensor, std::move(cloud)});
    else if (distance < needed_m && clouds.state(ref) == CloudState::obtainable)
      absent.emplace_back(distance, ref);
  }
  std::sort(absent.begin(), absent.end());
  if (absent.size() > static_cast<std::size_t>(config.clouds_requested))
    absent.resize(static_cast<std::size_t>(config.clouds_requested));
  // Enough is there when the request limit's worth of clouds is: the rest comes in the background.
  if (near.size() < static_cast<std::size_t>(config.clouds_requested))
    for (const auto& [distance, ref] : absent) missing.push_back(ref);
  return near;
}

const Judged& MergePipeline::State::judge_once(SessionId a, SessionId b, const Pose& T_0,
                                               std::span<const PlacedCloud> clouds_a,
                                               std::span<const PlacedCloud> clouds_b, AttemptReport& report) {
  auto& memory = judged[{a, b}];
  const std::size_t count = clouds_a.size() + clouds_b.size();
  for (const Judged& j : memory)
    if (j.clouds == count && !differ(j.T_0, T_0, 1e-9, 1e-9)) return j;
  const Stopwatch watch(report.times.registration_ms);
  const JudgeConfig judge_config{.threads = config.threads};
  if (memory.size() >= 4 * static_cast<std::size_t>(config.hypotheses)) memory.erase(memory.begin());
  memory.push_back({T_0, count, judge(clouds_a, clouds_b, T_0, judge_config)});
  return memory.back();
}

Alignment* MergePipeline::State::find(SessionId a, SessionId b) {
  for (Alignment& alignment : alignments)
    if (alignment.a == a && alignment.b == b) return &alignment;
  return nullptr;
}

void MergePipeline::State::move_to_flann(const FamilyId& id, std::size_t q_size) {
  auto index = make_flann_index(q_size);
  for (const auto& [session_id, session] : sessions)
    if (session.family == id)
      for (const Keyframe& k : session.keyframes)
        if (!k.descriptor.q.empty()) index->add({session_id, k.sequence}, k.descriptor.q);
  families[id].index = std::move(index);
}

MergePipeline::MergePipeline(const MergeConfig& config) : state_(std::make_unique<State>(config)) {}
MergePipeline::~MergePipeline() = default;

void MergePipeline::add_session(SessionId id, const FamilyId& family) {
  state_->sessions[id].family = family;
  Family& known = state_->families[family];
  if (known.compare) return;
  if (auto made = make_family(family.name); made && (*made)->id() == family) known.compare = std::move(*made);
}

void MergePipeline::add_keyframe(SessionId id, Keyframe keyframe) {
  Session& session = state_->sessions[id];
  Family& family = state_->families[session.family];
  const auto& q = keyframe.descriptor.q;
  if (!q.empty()) {
    if (!family.index) family.index = make_exact_index(q.size());
    if (family.index->size() == exact_up_to) state_->move_to_flann(session.family, q.size());
    family.index->add({id, keyframe.sequence}, q);
  }
  if (!session.keyframes.empty())
    session.path_m +=
        (keyframe.T_local_sensor.translation() - session.keyframes.back().T_local_sensor.translation()).norm();
  session.keyframes.push_back(std::move(keyframe));
}

void MergePipeline::complete_session(SessionId id) { state_->sessions[id].complete = true; }

Result<AttemptReport> MergePipeline::decide(AlignmentId id, Decision decision) {
  auto& alignments = state_->alignments;
  const auto found = std::find_if(alignments.begin(), alignments.end(), [&](const auto& k) { return k.id == id; });
  if (found == alignments.end())
    return failure(ErrorCode::not_found,
                   "there is no alignment " + std::to_string(id) + "; the atlas lists those there are");
  Alignment& alignment = *found;
  const auto record = state_->decisions.decide(alignment, decision);
  if (!record) return tl::unexpected(record.error());
  AttemptReport report;
  if (!*record) return report;
  report.decided.push_back(**record);
  if (const auto T_confirmed = state_->decisions.confirmed_at(id); T_confirmed && decision == Decision::undo)
    alignment.T_a_b = *T_confirmed;
  alignment.ruling = state_->decisions.ruling(alignment);
  alignment.state = decided_state(alignment);
  report.changed.push_back(alignment);
  state_->update_atlas(report);
  return report;
}

void MergePipeline::restore(std::vector<Alignment> alignments, std::uint64_t revision,
                            std::vector<DecisionRecord> decisions) {
  state_->alignments = std::move(alignments);
  state_->decisions.restore(std::move(decisions));
  for (Alignment& alignment : state_->alignments) alignment.ruling = state_->decisions.ruling(alignment);
  AttemptReport ignored;
  state_->update_atlas(ignored);
  state_->atlas.revision = revision;
}

const Atlas& MergePipeline::atlas() const { return state_->atlas; }
const std::vector<Alignment>& MergePipeline::alignments() const { return state_->alignments; }

}  // namespace headframe
