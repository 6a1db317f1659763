#pragma once
// The sources that propose where b could lie on a. Each has seats of its own, so that none crowds out another: one
// crossing that is right has little to set against thirty look-alikes along parallel tunnels.

#include <optional>
#include <span>
#include <vector>

#include "common/session/keyframe.hpp"
#include "server/place/descriptor_agreement.hpp"
#include "server/place/descriptor_matches.hpp"
#include "server/place/session_walls.hpp"

namespace headframe {

enum class ProposalSource {
  walls,           // long overlaps of the wall maps, weighed by the descriptors along the path
  coherent_walls,  // overlaps of the wall maps with hardly a contradiction, however short
  places,          // FRAME's rule: one pair of keyframes whose descriptors match, checked against the walls around it
  votes,           // the transforms that bring most keyframes together whose descriptors match
  hand,            // the operator laid the two on each other, roughly
};

/// A placement, and the part of b that bears it best.
struct Lead {
  const SessionWalls::Level* a = nullptr;
  const SessionWalls::Part* part = nullptr;
  WallMatch match;
  WallFit fit;  // of that part
  ProposalSource source = ProposalSource::walls;
  double promise = 0;  // fit.score(), weighed by how alike the descriptors are along both paths
  std::optional<Surroundings> around = std::nullopt;  // of places: the walls that it was refined by, and is judged by
};

/// How many of each source are handed on.
struct LeadSeats {
  std::size_t walls = 8, coherent = 40, places = 8, votes = 2;
  /// Placements of the wall search that are refined. In mines made by others a right one that shared a fifth of the
  /// rock was found as far down as 720.
  std::size_t coarse_matches = 1000;
  WallSearchSteps steps = {};
};

/// Leads of each source, refined to half a cell, best first, those of one source 4 m or 15 deg apart. Independent of
/// the thread count. `matches` may be empty: then the descriptors propose nothing.
std::vector<Lead> wall_leads(const SessionWalls& a, const SessionWalls& b, const DescriptorAgreement& agreement,
                             const LeadSeats& seats, int threads);
std::vector<Lead> place_leads(const SessionWalls& a, const SessionWalls& b, std::span<const Keyframe> of_a,
                              std::span<const Keyframe> of_b, const std::vector<MatchedPair>& matches,
                              const DescriptorAgreement& agreement, const LeadSeats& seats, int threads);
/// Votes lie on every pair of levels, and stay wherever the walls rank them.
std::vector<Lead> vote_leads(const SessionWalls& a, const SessionWalls& b, std::span<const Keyframe> of_a,
                             std::span<const Keyframe> of_b, const std::vector<MatchedPair>& matches,
                             const DescriptorAgreement& agreement, const LeadSeats& seats, int threads);

/// The placement as a transform without height.
Pose flat_placement(const WallMatch& match);

/// FRAME's T_0, for each of the best yaw differences: the levelled frames of the two keyframes on each other. Empty
/// without w.
std::vector<Pose> initial_transforms(const Keyframe& a, const Keyframe& b, std::size_t most_yaws);

}  // namespace headframe
