#pragma once
// From a hypothesis to a transform with evidence: register one place, then places spread over the overlap, each by
// itself; one T that suits them all; then what speaks against it. Verification decides, not the fit alone.

#include <span>

#include "server/atlas/alignment.hpp"
#include "server/registration/place_check.hpp"

namespace headframe {

struct JudgeConfig {
  double meet_m = 10;  // a keyframe of b this near to one of a's is a place of the overlap
  /// ... taken before those that lie farther off: there a corner hides most of what the other saw. (A drawn pair with
  /// 80 % of its rock in common waited for one such place, two more in tunnel-two.)
  double close_m = 5;
  double look_m = 35;               // clouds within this of the other session's keyframes take part
  std::size_t places = 6;           // at most
  double place_drift_m = 1.5;       // how far a place may move by itself: the drift of both sessions ...
  double place_drift_share = 0.02;  // ... and this much of its distance from the first place
  double place_drift_rad = 0.07;
  double held_by_nothing = 0.009;  // weakest hold of a bare drift: 0.007 is the noise of its scan lines
  double slide_m = 3;              // ... so far each way the drift is searched for where its ends meet
  double far_m = 18;    // ... and last, where neither robot came near the other's path, such as look into one hall
  double apart_m = 30;  // no hypothesis is looked at where the keyframes would stand farther apart
  std::size_t screened_fully = 14;  // hypotheses that go on to a full registration after the cheap one of all
  double hopeless_inliers = 0.15;   // at the first place: not looked at any closer
  double hopeless_violation = 0.08;
  PlaceConfig place;
  int threads = 1;
};

/// The first place of a hypothesis, registered and looked at.
struct Glance {
  bool hopeful = false;
  PlaceCheck place;
  PlacePtr a, b;
};

struct Judgement {
  RegistrationStatus status = RegistrationStatus::too_little_overlap;
  Pose T_a_b = Pose::Identity();  // means nothing unless status is converged or degenerate
  Evidence evidence;              // probability is set by the verdict; support and runner_up by the caller
};

/// A keyframe with a cloud: its number in its session, and where it stood in the local frame.
struct Stand {
  std::size_t keyframe = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
};

/// A session as the judge sees it.
struct Scene {
  std::vector<Stand> stands;  // within look_m of the other session's path, in the order of the session
  std::function<std::vector<PlacePtr>(std::span<const std::size_t> keyframes)> places;  // around each that is asked for
};

/// Where to look first: the keyframe of b nearest to p_b that comes near a, and the one of a nearest to it; where their
/// paths never meet, those nearest to p_b. Nothing when they lie too far apart.
struct Meeting {
  std::size_t keyframe_a = 0, keyframe_b = 0;
};
std::optional<Meeting> first_meeting(std::span<const Stand> a, std::span<const Stand> b, const Pose& T_a_b_0,
                                     const Eigen::Vector3d& p_b, const JudgeConfig& config);

/// Stands of b that come within reach of one of a's.
std::vector<Stand> near_other(std::span<const Stand> a, std::span<const Stand> b, const Pose& T_a_b, double reach_m);

/// Evidence::pairs and overlap_m.
void measure_overlap(Evidence& evidence, std::span<const Stand> a, std::span<const Stand> b, const Pose& T_a_b,
                     const JudgeConfig& config);

/// Share of b's points that match (Matched::cautious) after a short, coarse registration from T_a_b_0, which becomes
/// where that ended; 0 when it went astray. A tenth of the work of a glance, to tell which of many are worth one. Pure.
double screen(const Place& a, const Place& b, Pose& T_a_b_0);

/// Pure, thread safe.
Glance glance(const PlacePtr& a, const PlacePtr& b, const Pose& T_a_b_0, const JudgeConfig& config);

/// Goes on from a hopeful glance. Pure but for what the scenes do; independent of the thread count.
Judgement judge(const Scene& a, const Scene& b, const Glance& first, const JudgeConfig& config);

/// How far the first place, taken alone, fits as a copy of the rock would, 0 to 1: most points meet, surfaces lie on
/// each other, next to nothing contradicts, and nothing slides.
double likeness(const Glance& glance);

/// Whether the first place, taken alone, looks right. Where other placements do too, the mine repeats itself there.
bool fits_alone(const Glance& glance);

/// Probability that would be left to a placement with this glance, and with what `known` says of its descriptors, if
/// all else spoke for it: more than judge() can give.
double best_probability(const Glance& glance, const Evidence& known = {});

/// Both, trusting T_a_b_0 to within a metre or two: a published alignment looked at again with more keyframes.
Judgement judge_again(const Scene& a, const Scene& b, const Pose& T_a_b_0, const JudgeConfig& config);

/// Sets the probabilities of a judgement from the rest of its evidence.
void weigh(Judgement& judgement);

/// Probability that T_a_b is right; 0 unless the registration converged or is degenerate.
double probability(RegistrationStatus status, const Evidence& evidence);

}  // namespace headframe
