#pragma once
// One pair of sessions, from proposals to the verdict, against the truth.

#include <optional>
#include <string>

#include "tests/bench/pipeline_run.hpp"
#include "tests/bench/verdict_rows.hpp"

namespace headframe::bench {

/// What became of a pair.
struct PairRow {
  std::string set, world, a, b;
  double overlap_pct = 0, nearest_m = 0;
  int rank = -1;  // of the right proposal, from 0; -1: none
  ProposalSource source = ProposalSource::walls;
  int proposals = 0;
  bool screened = false;
  Judgement oracle;
  bool merged = false, right = false;
  double te_m = -1, ms = 0;
  std::size_t clouds = 0, clouds_sent = 0;  // of both sessions; those that the server asked for
  StageTimes times;
  std::optional<Evidence> found;  // of the alignment that was recorded, with its error
  double found_te_m = -1;
};

/// What two sessions truly have in common.
struct InCommon {
  double overlap_pct = 0, nearest_m = 0;
};

/// Share of the poses of the one that has fewer within 8 m of the other's, in place of the share of rock.
InCommon path_in_common(const DrivenSession& a, const DrivenSession& b);

/// Tries to merge b with a in a database of these two. Judged placements, and the true one, go into `rows`.
PairRow study(const DrivenSession& a, const DrivenSession& b, const InCommon& truth, Clouds clouds, VerdictRows& rows);

/// The true placement slides along a smooth tunnel.
bool degenerate(const PairRow& r);

/// By the share of rock that both saw: o30, o18, o10, o05, none; apart_paths where the paths never come near.
const char* bin_of(const PairRow& r);

/// A line for a pair that was lost or merged wrongly.
void print_if_lost(const PairRow& row);

}  // namespace headframe::bench
