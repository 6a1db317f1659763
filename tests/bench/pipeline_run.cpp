#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {

SessionId PipelineRun::add(const DrivenSession& session) {
  sessions.push_back(&session);
  const auto id = static_cast<SessionId>(sessions.size());
  pipeline.add_session(id, session.family);
  for (const Keyframe& keyframe : session.keyframes) {
    pipeline.add_keyframe(id, keyframe);
    pipeline.prepare_cloud({id, keyframe.sequence}, *this);
  }
  pipeline.complete_session(id);
  while (pipeline.prepare_ahead(*this)) {
  }
  return id;
}

SessionId PipelineRun::begin(const DrivenSession& session) {
  sessions.push_back(&session);
  const auto id = static_cast<SessionId>(sessions.size());
  pipeline.add_session(id, session.family);
  return id;
}

void PipelineRun::add_keyframe(SessionId id, std::size_t i) {
  const Keyframe& keyframe = session(id).keyframes[i];
  pipeline.add_keyframe(id, keyframe);
  pipeline.prepare_cloud({id, keyframe.sequence}, *this);
}

StageTimes PipelineRun::attempt(SessionId id) {
  StageTimes total;
  for (bool more = true; more;) {
    const AttemptReport report = pipeline.attempt(id, *this);
    traces.insert(traces.end(), report.traces.begin(), report.traces.end());
    for (const PairClosures& pair : report.closures) closures[{pair.a, pair.b}] = pair.places;
    more = report.unfinished || !report.wanted.empty();
    for (const KeyframeRef& cloud : report.wanted) {
      came_.insert(cloud);
      pipeline.prepare_cloud(cloud, *this);
    }
    total += report.times;
  }
  return total;
}

CloudState PipelineRun::state(const KeyframeRef& keyframe) const {
  return clouds_ == Clouds::at_once || came_.contains(keyframe) ? CloudState::stored : CloudState::obtainable;
}

Result<CloudDecoder> PipelineRun::load(const KeyframeRef& keyframe) {
  return [&cloud = session(keyframe.session).clouds.at(keyframe.sequence - 1)]() -> Result<KeyframeCloud> {
    return cloud;
  };
}

Outcome judge_outcome(const PipelineRun& run, SessionId a, SessionId b) {
  Outcome out;
  for (const Alignment& alignment : run.pipeline.alignments()) {
    if (alignment.a != a || alignment.b != b || alignment.state != AlignmentState::published) continue;
    out.merged = true;
    if (run.session(a).world != run.session(b).world) continue;
    out.error = nearest_overlap_error(run.session(a).path, run.session(b).path, alignment.T_a_b);
    out.right = out.error.pairs > 0 && out.error.translation_m < 1 && out.error.rotation_deg < 3;
  }
  return out;
}

}  // namespace headframe::bench
