// A session as it grows, and which of two is laid on the other.

#include <algorithm>
#include <bit>
#include <tuple>

#include "server/merge_state.hpp"
#include "server/place/sanity.hpp"

namespace headframe {
namespace {

/// Of all that was told of it but where it was (FNV-1a).
std::uint64_t mark_of(const Keyframe& keyframe) {
  std::uint64_t mark = 14695981039346656037ULL;
  const auto mix = [&](std::uint64_t value) { mark = (mark ^ value) * 1099511628211ULL; };
  mix(std::bit_cast<std::uint64_t>(keyframe.stamp_s));
  for (const float f : keyframe.descriptor.q) mix(std::bit_cast<std::uint32_t>(f));
  for (const std::uint8_t code : keyframe.walls.code) mix(code);
  return mark;
}

}  // namespace

void Session::add(Keyframe keyframe) {
  const Eigen::Vector3d here = keyframe.T_local_sensor.translation();
  if (keyframes.empty()) mark = mark_of(keyframe);
  path_to_m.push_back(keyframes.empty() ? 0 : path_m() + (here - keyframes.back().T_local_sensor.translation()).norm());
  keyframes.push_back(std::move(keyframe));
  set_aside_odd();
}

void Session::set_aside_odd() {
  const std::size_t n = keyframes.size(), known = complete ? n : n - std::min<std::size_t>(n, 2);
  for (; asked < known; ++asked) {
    Keyframe& k = keyframes[asked];
    if (fits_neighbours(keyframes, asked)) continue;
    k.walls = {};
    k.point_count = 0;
    k.descriptor = {};
  }
}

Laid MergePipeline::State::laid(SessionId one, SessionId other) const {
  const auto rank = [&](SessionId id) { return std::tuple(sessions.at(id).path_m(), sessions.at(id).mark, id); };
  return rank(one) < rank(other) ? Laid{one, other} : Laid{other, one};
}

AttemptReport MergePipeline::State::given_out(AttemptReport report) {
  for (Alignment& alignment : report.changed) alignment = frames.given_out(alignment);
  for (PairTrace& trace : report.traces) {
    const auto give_out = [&](Pose& T_a_b) { T_a_b = frames.given_out(trace.a, trace.b, T_a_b); };
    for (PairTrace::Proposal& proposal : trace.proposed) give_out(proposal.T_a_b);
    for (Pose& T_a_b : trace.screened) give_out(T_a_b);
    for (Judgement& judged : trace.judged) give_out(judged.T_a_b);
  }
  for (DecisionRecord& record : report.decided) {
    const auto of = std::find_if(alignments.begin(), alignments.end(),
                                 [&](const Alignment& a) { return a.id == record.alignment; });
    record.T_a_b = frames.given_out(of->a, of->b, record.T_a_b);
  }
  atlas_given_out = frames.given_out(atlas);
  alignments_given_out.clear();
  for (const Alignment& alignment : alignments) alignments_given_out.push_back(frames.given_out(alignment));
  return report;
}

void MergePipeline::State::forget(SessionId id) {
  sessions.erase(id);
  frames.come_anew(id);
  const auto of_it = [id](const auto& entry) { return entry.first.first == id || entry.first.second == id; };
  std::erase_if(judged_on, of_it);
  std::erase_if(contacts, of_it);
}

void MergePipeline::State::wake_alignments(SessionId id) {
  for (Alignment& alignment : alignments)
    if (alignment.a == id || alignment.b == id) alignment.state = decided_state(alignment);
}

void MergePipeline::State::take_back(std::vector<Alignment> stored, std::vector<DecisionRecord> decided) {
  alignments = std::move(stored);
  for (Alignment& alignment : alignments) alignment = frames.local(alignment);
  for (DecisionRecord& record : decided)
    if (const auto of = std::find_if(alignments.begin(), alignments.end(),
                                     [&](const Alignment& a) { return a.id == record.alignment; });
        of != alignments.end())
      record.T_a_b = frames.local(of->a, of->b, record.T_a_b);
  decisions.restore(std::move(decided));
}

Pose by_ids(const Laid& pair, const Pose& T) { return pair.a < pair.b ? T : T.inverse(); }

Judgement by_ids(const Laid& pair, Judgement judgement) {
  if (pair.a < pair.b) return judgement;
  judgement.T_a_b = judgement.T_a_b.inverse();
  std::swap(judgement.evidence.overlap_a, judgement.evidence.overlap_b);
  return judgement;
}

}  // namespace headframe
