#pragma once
// The methods that propose where b could lie on a. Each has its own quota, so that none crowds out another: a right
// placement at a single crossing has little support compared with thirty look-alikes along parallel tunnels.

#include <optional>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/place/descriptor_agreement.hpp"
#include "server/place/descriptor_matches.hpp"
#include "server/place/session_walls.hpp"

namespace headframe {

enum class ProposalSource {
  walls,           // long overlaps of the wall maps, weighted by how similar the descriptors are along the path
  coherent_walls,  // overlaps of the wall maps with almost no contradiction, however short
  places,          // FRAME's rule: one pair of keyframes whose descriptors match, checked against the walls around it
  votes,           // the transforms under which most keyframes with matching descriptors coincide
  hand,            // the operator placed one session on the other, roughly
};

/// A proposed placement, and the part of one session that supports it most, laid on a level of the other.
struct Lead {
  const SessionWalls::Level* a = nullptr;
  const SessionWalls::Level* b = nullptr;
  const SessionWalls::Part* part = nullptr;  // of b, laid on a; or, if a_on_b, of a, laid on b
  bool a_on_b = false;
  WallMatch match;  // of the part on the level
  WallFit fit;      // likewise
  ProposalSource source = ProposalSource::walls;
  double promise = 0;  // fit.score(), weighted by the similarity of the descriptors along both paths
  std::optional<Surroundings> around = std::nullopt;  // for source `places`: the walls used to refine and score it
  std::optional<double> height_m = std::nullopt;      // for source `places`: of b's frame in a's, by the two keyframes

  const WallField& field() const { return a_on_b ? b->field : a->field; }
  /// Without height.
  Pose T_a_b() const;
  /// The middle of the walls that meet, in b's frame.
  Eigen::Vector2d middle_b() const { return a_on_b ? middle_at(match, fit.middle) : fit.middle; }
};

/// How many proposals of each method are passed on.
struct LeadSeats {
  std::size_t walls = 16, coherent = 40, places = 8, votes = 2;
  /// Results of the wall search that are refined. In mines made by others, a right placement that shared a fifth of the
  /// rock was found only at rank 720 in
  /// cells of 1.5 m.
  std::size_t coarse_matches = 1000;
  /// Of these, each with the parts that support it, so many that fit best are refined, for each pair of levels; all, if
  /// the session is so long that its pieces are searched one by one.
  std::size_t refined = 500;
  WallSearchSteps steps = {};
  std::size_t spare = 8;    // refined to half a cell: this many times the quota, half as many of `coherent`
  bool both_orders = true;  // parts of a are laid on b, too, with seats of their own
  bool second_part = true;  // for each placement also the part whose walls meet most, though they contradict more
};

/// A placement under which two keyframes describe one place.
struct PlacedPair {
  std::size_t a = 0, b = 0;  // indices of the keyframes
  Pose T_a_b = Pose::Identity();
};

/// The two likeliest placements for each of the most informative matches: similar to each other, and not similar to
/// everything; these first.
std::vector<PlacedPair> placed_pairs(std::span<const Keyframe> of_a, std::span<const Keyframe> of_b,
                                     std::vector<MatchedPair> matches, int threads);

/// The best proposals of each method, refined to half a cell, best first; those of one method are 4 m or 15 deg apart.
/// Independent of the thread count. `placed` may be empty: then the descriptors propose nothing.
std::vector<Lead> wall_leads(const SessionWalls& a, const SessionWalls& b, const DescriptorAgreement& agreement,
                             const LeadSeats& seats, int threads);
std::vector<Lead> place_leads(const SessionWalls& a, const SessionWalls& b, std::span<const Keyframe> of_b,
                              std::span<const PlacedPair> placed, const DescriptorAgreement& agreement,
                              const LeadSeats& seats, int threads);
/// Votes are proposed on every pair of levels, and are kept whatever their walls' score.
std::vector<Lead> vote_leads(const SessionWalls& a, const SessionWalls& b, std::span<const Keyframe> of_b,
                             std::span<const PlacedPair> placed, const DescriptorAgreement& agreement,
                             const LeadSeats& seats, int threads);

/// FRAME's T_0 for each of the best yaw differences: places the levelled frame of keyframe b on that of keyframe a.
/// Empty without w.
std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, std::size_t most_yaws);

}  // namespace headframe
