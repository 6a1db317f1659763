#pragma once
// Where a session is like itself, and what of it speaks against a placement.

#include <algorithm>
#include <set>
#include <span>

#include "server/session/self_likeness.hpp"
#include "server/verification/meeting.hpp"
#include "server/verification/screening_result.hpp"

namespace headframe {

/// The places of a session, placed on itself, that fit elsewhere. Those whose placements are the same have the same
/// number; those near the identity are left out. copies: which of them fit for 15 m and more.
std::vector<LikePlace> like_places(const std::vector<ScreeningResult>& screened, const std::set<std::size_t>& copies);

/// Sets aliases, look_alikes and similar_places to what the places show: each placement counts as its best place does,
/// of copies each place.
void count_places(SelfLikeness& likeness);

/// What of it lies within 12 m of one of these positions, either end of it: a session that is like itself elsewhere
/// does not say that these places could be others. All of it if it is not known where it is, or without positions.
SelfLikeness likeness_at(const SelfLikeness& likeness, std::span<const KeyframePosition> positions);

/// How many look-alikes an overlap has to be expected to have for each 100 m of path. `of_mine`: how many any place
/// has, as all sessions show; that weighs as much as 200 m of path. `a` and `b`: likeness_at() the overlap; what is
/// like none of the places that the two have passed is rarer than others. Not fewer than of_mine where the descriptors
/// of the placement differ (fully from four on that agree to .72 and less, not from .76 on): a copy of 58 m of a cave,
/// with twelve of .64, stood for 3.5 s in a live drive while little was known of it.
double expected_look_alikes(double of_mine, const SelfLikeness& a, const SelfLikeness& b, const Evidence& descriptors);

/// So many for each 100 m of path, taken over at least least_m.
inline double per_100_m(double count, double path_m, double least_m) { return 100 * count / std::max(path_m, least_m); }

/// Path from which on it is known whether the places of a mine are similar to each other.
inline constexpr double well_known_m = 200;

/// Similar places to be expected per 100 m of a mine of which all sessions have shown so many on so much path. What is
/// missing from 200 m of path counts as if it held half a one per 100 m, at which the verdict's curve ends.
double expected_similar_places(double found, double path_m);

/// The path that was searched for places alike; none before the clouds that allow it are there.
double searched_m(const SelfLikeness& likeness);

}  // namespace headframe
