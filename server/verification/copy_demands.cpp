#include "server/verification/copy_demands.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "server/verification/ramp.hpp"
#include "server/verification/tile_weights.hpp"

namespace headframe {
namespace {

/// Where the mine repeats itself, exact copies pass every local test; only a longer overlap tells them apart. Costs at
/// most 4.1 for each 42 m demanded.
double missing_overlap(const Evidence& e) {
  const double asked_m = asked_overlap_m(e);
  if (asked_m <= 0) return 0;
  const double most = 0.34 * asked_m / asked_first_m;
  return 12 * std::max(-most, std::min(0.0, e.overlap_m / asked_m - 1));
}

/// Among look-alikes each metre missing from asked_among_look_alikes_m() costs 0.1. The cost is limited to 1.5, or
/// right placements of 28 m among copies would wait. Among many look-alikes (fully from 4.3 on, not at all up to 2.7)
/// the limit rises by 0.3 for each metre below 50 (70 from eighteen look-alikes on), or below 28 if no descriptors were
/// compared or they are nearly equal. Among the drives through a mine of equal tunnels, many of them with many
/// look-alikes, four right placements of 25 to 47 m reached 0.9, and six copies.
double short_among_look_alikes(const Evidence& e) {
  const double many = ramp(e.look_alikes, 2.7, 4.3);
  const double more_m = 22 + 2 * std::clamp(e.look_alikes - 8, 0.0, 10.0);
  const double told_m = 28 + descriptors_leave_doubt(e) * more_m;
  const double most = 1.5 + 0.3 * many * std::max(0.0, told_m - e.overlap_m);
  return std::max(-most, 0.1 * std::min(0.0, e.overlap_m - asked_among_look_alikes_m(e)));
}

/// 1 where a place disagrees though the walls hold the placement (fully from .05 on, not up to .03).
double held_place_disagrees(const Evidence& e) {
  const double held = ramp(e.weakest_hold, 0.03, 0.05);
  return held * std::clamp(e.places - e.places_agreeing, 0.0, 1.0);
}

/// 1 where places lie apart (fully from 0.8 m on, not up to 0.6) though the walls hold the placement (fully from .02
/// on, not up to .017).
double held_places_lie_apart(const Evidence& e) {
  const double held = ramp(e.weakest_hold, 0.017, 0.02);
  return held * ramp(e.spread_m, 0.6, 0.8);
}

/// 1 up to a weakest hold of .08, 0 from .11 on.
double held_loosely(const Evidence& e) { return ramp(e.weakest_hold, 0.11, 0.08); }

/// 1 for a straight tunnel, whose walls hardly hold the placement along it (up to .04, not from .05 on).
double straight(const Evidence& e) { return ramp(e.weakest_hold, 0.05, 0.04); }

/// How far a copy has to be reckoned with, 0 to 1: where copies were seen, and in a straight tunnel if the
/// descriptors of eight keyframes and more (not of up to four) agree to .72 and less, not from .76 on. Two copies
/// of 66 and 80 m of a straight tunnel agreed to .70; right ones to as little only where the mine shows no
/// look-alikes.
double copy_expected(const Evidence& e) {
  const double unlike = ramp(e.descriptors_alike, 0.76, 0.72) * ramp(e.descriptors_compared, 4, 8);
  return std::max(copies_shown(e), straight(e) * unlike);
}

/// Overlap that is missing where places lie apart among look-alikes though the walls hold the placement (fully from
/// .023 on, not up to .018), because drift explains no such distance over a short overlap. 45 m are demanded from 0.35
/// m and 1.4 look-alikes on (nothing up to 0.2 m or one); 36 m from 0.46 m and 0.3 similar places on (nothing up to
/// 0.36 m or .15), unless the descriptors are nearly equal (.95 to .97). Of placements that reached .9 without this,
/// five of 16 to 27 m were copies, and two of 27 and 32 m right.
double missing_where_look_alikes_lie_apart(const Evidence& e) {
  const double similar = ramp(e.similar_places, 0.15, 0.3) * ramp(e.descriptors_alike, 0.97, 0.95);
  return ramp(e.weakest_hold, 0.018, 0.023) *
         std::max({0.0, ramp(e.look_alikes, 1, 1.4) * ramp(e.spread_m, 0.2, 0.35) * (45 - e.overlap_m),
                   similar * ramp(e.spread_m, 0.36, 0.46) * (36 - e.overlap_m)});
}

/// If another placement fits, places look alike, or places lie apart though the walls hold them, the descriptors of
/// a short overlap (fully up to 26 m, not from 36 m on) have to decide. Of 11 such right placements in six kinds of
/// mines, with less than 36 m and at least four descriptors, 10 had a similarity of 0.85 and more, and one 0.77,
/// over 32 m; a smooth tunnel was merged wrongly over 23 m, with 0.76 to 0.78 from five. Costs 6 at most, with four
/// or more descriptors (nothing with two; a copy of 13 m of mixed tunnels had three of .58), from a quarter of a
/// look-alike on: with half of that cost a copy of 28 m in equal tunnels, whose places lie 0.77 m apart, 0.69 from
/// five, reached 0.91. Look-alikes count only where copies were seen or the walls hold the placement loosely: two right
/// ones of rough tunnels, of 16 and 30 m, had a fifth of one. Set by hand on these; not part of the fit.
double descriptors_have_to_decide(const Evidence& e) {
  const double alike = std::max(copies_shown(e), held_loosely(e)) * e.look_alikes / 0.25;
  const double likeness = std::min(1.0, std::max({e.aliases / 0.2, alike, held_places_lie_apart(e)}));
  return -6 * likeness * ramp(e.descriptors_compared, 2, 3.5) * ramp(e.overlap_m, 36, 26) *
         ramp(e.descriptors_alike, 0.83, 0.76);
}

/// Whatever looks alike, descriptors that differ (fully at a similarity of .72 and less, not from .76 on) are a doubt
/// over 40 m and less (nothing from 50 on), in full from five on (nothing with three): in live drives through a cave of
/// tiles, of whose likeness to itself nothing was known yet, copies of 34 to 40 m were merged, with .66 to .72 from
/// five to nine. Costs 6 at most. Of 1601 accepted right placements 12 wait for it.
double descriptors_differ(const Evidence& e) {
  return -6 * ramp(e.descriptors_compared, 3, 5) * ramp(e.overlap_m, 50, 40) * ramp(e.descriptors_alike, 0.76, 0.72);
}

/// A nearly straight tunnel demands 75 m, whatever looks alike, and each metre missing costs 0.3, at most 6 in all:
/// of 32 placements that would be accepted without, 23 are right. It is one where the walls hold the placement
/// loosely along it (fully up to .05, not from .06 on) and what stands across it does not match well (fully up to a
/// share of .4, not from .5 on), unless the descriptors of three keyframes and more (one tells nothing) agree to
/// .92 (not up to .89). All four copies of 18 to 60 m that merged in a mine laid out anew of tiles of rough
/// tunnels, of which nothing had looked alike, wait for it; at them .24 to .4 matched, at right ones between smooth
/// pillars .44 to .68.
double short_in_nearly_straight_tunnel(const Evidence& e) {
  const double differ = ramp(e.descriptors_compared, 1, 3) * ramp(e.descriptors_alike, 0.92, 0.89);
  const double open_along = ramp(e.weakest_hold, 0.06, 0.05) * ramp(e.end_on_match, 0.5, 0.4);
  return -open_along * differ * std::clamp(0.3 * (75 - e.overlap_m), 0.0, 6.0);
}

/// In a mine that looks like itself, one pair of sessions cannot show how many copies there are. So it demands the
/// longest of these overlaps, and each metre missing costs 0.3:
/// - where a copy has to be reckoned with (copy_expected), 60 m if the descriptors agree to .90 or less, falling to
///   nothing at .93; 40 m more if it is nearly straight (the walls hardly hold it along the tunnel);
/// - there, and from four look-alikes on, or about one where all sessions together show some (fully from 0.38 per 100 m
///   on, not up to 0.3), 56 m if they agree to .94 or less, falling to nothing at .955, because one of many copies may
///   have such descriptors; 20 m more if it is nearly straight, and 2 m for each look-alike beyond seven;
/// - 60 m if a place disagrees though the walls hold it (fully from .05 on, not up to .03), or if places lie apart
///   though the walls hold them: each piece of a copy fits at its own place. Of those that reached .85, copies of 27 to
///   58 m lay apart by 0.56 to 1.41 m; right ones by 0.59 m at most, but for one of 1.10 m, for which the descriptors
///   do not speak either, and two of 0.72 and 0.94 m that slide along a tunnel;
/// - 60 m if points scatter (fully from .132 m on, not up to .112), as at an accepted copy of 50 m; at 86 accepted
///   right ones of 19 to 125 m among more than two look-alikes, by .112 m at most.
/// Each metre of missing_where_look_alikes_lie_apart() costs as much. Set by hand
/// on worlds of equal tunnels. Of the placements of 25 to 57 m there for which all else spoke, 21 of 44 were copies.
/// With descriptors of .91 to .95, copies of 24, 36, 39, 41, 44, 44, 50, 53, 58, 66, 83 and 84 m were accepted; and one
/// of 37 m, .96, where one place of six disagreed, as at none of the right ones that the walls hold.
double short_in_mine_of_copies(const Evidence& e) {
  const double compared = std::min(1.0, e.descriptors_compared);
  const double differ = ramp(e.descriptors_alike, 0.93, 0.9);
  const double of_mine = ramp(e.mine_look_alikes, 0.3, 0.38);
  const double copies =
      std::max(of_mine * ramp(e.look_alikes, 0.95, 1.35), std::clamp((e.look_alikes - 3.5 + of_mine) / 0.8, 0.0, 1.0));
  const double by_chance = copies * ramp(e.descriptors_alike, 0.955, 0.94);
  const double many_m = 2 * std::clamp(e.look_alikes - 7, 0.0, 10.0);
  const double scattered = ramp(e.rmse_m, 0.112, 0.132);
  const double of_copies_m = std::max(differ * (60 + 40 * straight(e)), by_chance * (56 + 20 * straight(e) + many_m));
  const double told_m = 60 * std::max(held_place_disagrees(e), held_places_lie_apart(e));
  const double missing_m = std::max(
      {0.0, told_m - e.overlap_m, copy_expected(e) * (of_copies_m - e.overlap_m), scattered * (60 - e.overlap_m)});
  return -0.3 * compared * std::max(looks_like_itself(e) * missing_m, missing_where_look_alikes_lie_apart(e));
}

/// If at most one descriptor was compared, which says little, only the length of the overlap and how well the walls
/// hold it tell a copy from the place itself. Where places look alike (fully from one look-alike on, not up to 0.4)
/// and the walls do not hold it firmly (held_loosely()), or where the mine looks like itself, each metre below 28 m
/// costs 0.3; below 60 m where the walls hold it loosely (fully up to .06, not from .07 on), there also if only a
/// place disagrees; below 15 m more from three look-alikes on (not up to two) where it is held by .07 and less (not
/// from .08 on); and below 40 m among similar places (fully from 2.6 on, not up to 1.6; a copy of 25 m among 3.5
/// was accepted, right ones among up to 1.5). Below 15 m, whatever looks alike, each metre costs as much if places
/// lie apart (fully from 0.2 m on, not up to 0.1) and the walls do not hold them firmly (held_loosely()): drift
/// explains no such distance there. Set by hand on crossed drives through five worlds, of robots with descriptors
/// of two families: eight copies of 17 to 58 m were accepted, all held by less than .07; at one of them nothing
/// looked alike, but a place disagreed. A ninth, of 6 m and held by .071, had a tenth of a look-alike and places
/// 0.24 m apart. Of the right ones below 15 m that reached .9, one is held by less than .11 and lies more than 0.1
/// m apart: in a cave, 11 m, held by .104. That walls which hold firmly make up for look-alikes lets eight right
/// ones of 6 to 23 m merge, and no copy. Below 36 m, whatever looks alike, a place that is contradicted a little
/// (fully from .12 % of its points on, not up to .03 %) costs as much: of placements of mines laid out of tiles that
/// reached .05, all fifteen with such a place were copies.
double short_without_descriptors(const Evidence& e) {
  const double absent = std::clamp(2 - e.descriptors_compared, 0.0, 1.0);
  const double loosely = ramp(e.weakest_hold, held_firmly, 0.06);
  const double alike = held_loosely(e) * ramp(e.look_alikes, 0.4, 1);
  const double doubt = std::max({looks_like_itself(e), alike, loosely * held_place_disagrees(e)});
  const double many = ramp(e.look_alikes, 2, 3) * ramp(e.weakest_hold, 0.08, 0.07);
  const double asked_m = 28 + 32 * loosely + 15 * many;
  const double apart = ramp(e.spread_m, 0.1, 0.2) * held_loosely(e);
  const double similar = ramp(e.similar_places, 1.6, 2.6);
  const double contradicted = ramp(worst_place_contradiction(e), 3e-4, 1.2e-3);
  return -0.3 * absent *
         std::max({0.0, doubt * (asked_m - e.overlap_m), similar * (40 - e.overlap_m), apart * (15 - e.overlap_m),
                   contradicted * (36 - e.overlap_m)});
}

/// The log-odds that a placement over a short overlap with few descriptors is right, if all else speaks for it.
double told_from_a_tile(const Evidence& e) {
  const double n = e.descriptors_compared;
  const std::array<double, 4> told{std::clamp(e.support, 0.0, tile_most_cells) / 50, (0.1 - e.rmse_m) / 0.02,
                                   std::log2(15 / std::max(e.overlap_m, 4.0)),
                                   n / (n + 2) * (e.descriptors_alike - 0.75) / 0.1};
  return std::inner_product(told.begin(), told.end(), tile_weights.begin(), tile_bias);
}

}  // namespace

double short_among_copies(const Evidence& e) { return std::min(missing_overlap(e), short_among_look_alikes(e)); }

double hardly_told_apart(const Evidence& e) {
  return std::min({descriptors_have_to_decide(e), descriptors_differ(e), short_in_nearly_straight_tunnel(e),
                   short_in_mine_of_copies(e), short_without_descriptors(e)});
}

double short_and_little_tells(const Evidence& e) {
  if (e.support == 0) return 0;
  const double brief = ramp(e.overlap_m, 44, 36) * ramp(e.descriptors_compared, 12, 8);
  return -brief * std::clamp(tile_cost * (tile_told - told_from_a_tile(e)), 0.0, tile_most_cost);
}

}  // namespace headframe
