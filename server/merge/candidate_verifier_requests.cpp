// Which clouds the verdicts of a pair ask for.
#include <algorithm>

#include "server/merge/candidate_verifier.hpp"

namespace headframe {
namespace {

/// So many cases that failed where they were tried request clouds of another place: the right one is nearly always
/// among these (MergePipeline::State::judge_cases).
constexpr std::size_t likeliest_cases = 3;

}  // namespace

/// One place may say nothing, also of the right placement. What was proposed after a hopeful case is not tried again.
std::vector<KeyframeRef> CandidateVerifier::clouds_for_another_look(
    const OrderedPair& pair, const std::vector<Case>& cases, const std::vector<ScreeningResult>& screened) const {
  std::vector<KeyframeRef> wanted;
  for (std::size_t i = 0; i < std::min(likeliest_cases, cases.size()) && !screened[i].hopeful && wanted.empty(); ++i)
    wanted = requests_.clouds_for_further_screening(pair, cases[i]);
  return wanted;
}

bool CandidateVerifier::ask_for_more(const OrderedPair& pair, const Verdicts& verdicts, std::size_t awaited,
                                     const Attempt& attempt) const {
  const std::vector<Verdict>& all = verdicts.judged;
  if (!convinces(all.front().judgement.evidence, config_)) {
    const auto asks = std::find_if(all.begin(), all.end(), [](const Verdict& v) { return !v.wanted.empty(); });
    if (asks != all.end())
      attempt.want(asks->wanted);
    else if (worth_all_clouds(pair, all.front()))
      return ask_for_all(pair, attempt) &&
             all.front().judgement.evidence.probability_if_unique >= config_.accept_probability;
    else if (awaited == 0)
      attempt.want(verdicts.another_look);
    return false;
  }
  if (awaited > 0) return false;  // it has to wait for its rivals anyway
  std::vector<KeyframeRef> wanted = all.front().wanted;
  for (const SessionId id : {pair.a, pair.b})
    for (const KeyframeRef& k : self_.last(id).wanted)
      if (attempt.clouds.state(k) == CloudState::obtainable) wanted.push_back(k);
  attempt.want(wanted);
  return !wanted.empty();
}

bool CandidateVerifier::ask_for_all(const OrderedPair& pair, const Attempt& attempt) const {
  std::vector<KeyframeRef> wanted;
  for (const SessionId id : {pair.a, pair.b})
    for (const Keyframe& keyframe : sessions_.at(id).keyframes)
      if (const KeyframeRef k{id, keyframe.sequence}; attempt.clouds.state(k) == CloudState::obtainable)
        wanted.push_back(k);
  attempt.want(wanted);
  return !wanted.empty();
}

/// Whether the pair has ended and the placement is a candidate, or would be accepted if the mine were not like itself:
/// few clouds show more copies than there are, less rock, and a shorter overlap.
bool CandidateVerifier::worth_all_clouds(const OrderedPair& pair, const Verdict& best) const {
  const Evidence& e = best.judgement.evidence;
  return sessions_.have_ended(pair) &&
         (e.probability >= config_.candidate_probability || e.probability_if_unique >= config_.accept_probability);
}

}  // namespace headframe
