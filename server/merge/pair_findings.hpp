#pragma once
// What is found of a pair of sessions before anything beside these two counts, and its bytes.

#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "server/place/hypotheses.hpp"
#include "server/session/self_likeness.hpp"
#include "server/verification/verification.hpp"

namespace headframe {

/// A screening result that is hopeful, without its submaps.
struct HopefulCase {
  std::size_t hypothesis = 0;
  SubmapCheck place;
};

/// What judge() says of it: the evidence of the two sessions alone, before anything else is weighed.
struct JudgedCase {
  std::size_t hypothesis = 0;
  Judgement judgement;
};

/// Of two sessions: where one could lie on the other. Of one session: how it looks like itself.
struct PairFindings {
  std::vector<Hypothesis> hypotheses;  // as HypothesisFinder finds them
  std::vector<HopefulCase> hopeful;    // those that passed screening, in the order of the hypotheses
  std::vector<JudgedCase> judged;      // those of them that will probably be judged
  SelfLikeness itself;
};

/// Numbers go as they are in memory, so that they come back the same to the bit.
std::string encode_findings(const PairFindings& findings);
/// bad_input: these are not the bytes that encode_findings() made.
Result<PairFindings> decode_findings(std::string_view bytes);

}  // namespace headframe
