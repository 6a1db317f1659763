#include "server/atlas/explain.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace headframe {
namespace {

// Where a figure begins to speak against a placement: what the verdict (server/registration/verification.cpp) weighs.
constexpr double few_pairs = 3, few_points = 6000, good_inliers = 0.6, free_to_slide = 0.012;
constexpr double violation_ratio = 1.5, violation_floor = 0.001;  // against what each session does to itself
constexpr double slid_as_well = 0.97, tilted_deg = 1.5, thin_overlap = 0.1;

template <class... Values>
std::string text(const char* format, Values... values) {
  std::array<char, 400> out;
  const int size = std::snprintf(out.data(), out.size(), format, values...);
  return {out.data(), std::min(static_cast<std::size_t>(std::max(size, 0)), out.size() - 1)};
}

Speaks side(bool against) { return against ? Speaks::against : Speaks::in_favour; }

bool violated(const Evidence& e) {
  return e.freespace_violation + violation_floor > violation_ratio * (e.own_violation + violation_floor);
}

std::vector<Finding> findings_of(const Evidence& e) {
  std::vector<Finding> out;
  const auto add = [&](std::string_view name, double value, Speaks speaks, std::string words) {
    if (std::isfinite(value)) out.push_back({name, value, speaks, std::move(words)});
  };
  add("inlier_fraction", e.inlier_fraction, side(e.inlier_fraction < good_inliers),
      text("%.0f %% of the points where they meet have a partner in the other map, %.0f mm apart on average",
           100 * e.inlier_fraction, 1000 * e.rmse_m));
  add("freespace_violation", e.freespace_violation, side(violated(e)),
      text("%.2f %% of the points lie where the other's rays passed through; %.2f %% do so within each session itself",
           100 * e.freespace_violation, 100 * e.own_violation));
  if (e.farther_violation > 0)
    add("farther_violation", e.farther_violation, side(e.farther_violation >= contradicted_farther),
        text("%.2f %% do so up to 25 m away at one place: a copy would end there", 100 * e.farther_violation));
  add("overlap_a", e.overlap_a, side(std::min(e.overlap_a, e.overlap_b) < thin_overlap),
      text("near the overlap the second has seen %.0f %% of the first's points, the first %.0f %% of the second's",
           100 * e.overlap_a, 100 * e.overlap_b));
  add("seen_points", e.seen_points, side(e.seen_points < few_points), text("%.0f points speak for it", e.seen_points));
  add("pairs", e.pairs, side(e.pairs < few_pairs), text("%.0f keyframes come within 10 m of the other's", e.pairs));
  if (e.places > 0)
    add("places_agreeing", e.places_agreeing, side(e.places_agreeing < e.places),
        text("%.0f of %.0f places along the overlap, registered each by itself, agree; they would move by %.2f m",
             e.places_agreeing, e.places, e.spread_m));
  add("weakest_hold", e.weakest_hold, side(e.weakest_hold < held_well),
      e.weakest_hold < free_to_slide ? "the walls do not hold the position along the drift"
      : e.weakest_hold < held_well   ? "the walls hardly hold the position along the drift"
                                     : "the walls hold the position in every direction");
  if (e.slide_ratio > 0)
    add("slide_ratio", e.slide_ratio, side(e.slide_ratio > slid_as_well),
        text("slid a few metres along its weakest direction it fits %.0f %% as well", 100 * e.slide_ratio));
  add("end_on_match", e.end_on_match, side(e.weakest_hold < held_well && e.end_on_match < ends_meet),
      text("of the surfaces that face along it %.0f %% meet", 100 * e.end_on_match));
  if (e.descriptors_compared > 0)
    add("descriptors_alike", e.descriptors_alike, side(e.descriptors_alike < asked_alike(e)),
        text("%.0f keyframes stand where one of the other's stood; what they describe is %.0f %% alike",
             e.descriptors_compared, 100 * e.descriptors_alike));
  add("tilt_deg", e.tilt_deg, side(e.tilt_deg > tilted_deg),
      text("the two disagree on gravity by %.2f deg", e.tilt_deg));
  add("runner_up", e.runner_up, Speaks::neither,
      e.runner_up > 0 ? text("the best different placement has probability %.2f", e.runner_up)
                      : "no different placement fits");
  return out;
}

std::string text_of(const FamilyId& family) { return family.name + " version " + std::to_string(family.version); }

std::string placement_of(const Alignment& k) {
  const Eigen::Vector3d t = k.T_a_b.translation();
  return text("at x %.1f, y %.1f, z %.1f m, turned by %.1f deg, with probability %.3f", t.x(), t.y(), t.z(),
              yaw_rad(k.T_a_b) * 180 / std::numbers::pi, k.evidence.probability);
}

std::string decision_of(Ruling ruling) {
  switch (ruling) {
    case Ruling::confirmed: return "confirmed by the operator: it stays whatever the evidence says";
    case Ruling::refused: return "refused by the operator: not proposed again until there is twice the evidence";
    case Ruling::retracted: return "retracted by the operator: not proposed again until there is twice the evidence";
    case Ruling::none: break;
  }
  return {};
}

std::string outcome_of(const std::string& both, const Alignment& k, bool together, const MergeConfig& config) {
  if (k.state == AlignmentState::published) return both + " are merged: " + placement_of(k);
  const std::string apart =
      together ? both + " are merged through other sessions; of the pair itself: " : both + " are not merged: ";
  if (!has_placement(k)) return apart + "no placement was found that fits";
  const std::string best = "; the best placement is " + placement_of(k);
  if (k.ruling == Ruling::refused) return apart + "the operator refused the placement" + best;
  if (k.ruling == Ruling::retracted) return apart + "the operator retracted the merge" + best;
  switch (k.state) {
    case AlignmentState::verified:
      return apart + "it stands up, but " +
             (k.objection ? "other sessions contradict it" : "contradicts stronger alignments") + best;
    case AlignmentState::retracted: return apart + "it was merged once, and later evidence contradicts it" + best;
    case AlignmentState::candidate:
      return apart +
             (convinces(k.evidence, config) ? "it looks right, and waits" : "it may be right, but is not sure enough") +
             best;
    case AlignmentState::rejected:
    case AlignmentState::published: break;
  }
  return apart + "nothing stands up" + best;
}

/// What speaks of one session whatever became of the pair.
void add_troubles(const ExplainedSession& s, std::vector<std::string>& missing) {
  if (!s.why_aside.empty())
    missing.push_back(s.name + " is set aside (" + s.why_aside + "): headframe session release takes it back");
  if (!s.why_cut.empty())
    missing.push_back(s.name + ": " + s.why_cut +
                      "; what comes after is not merged with the rest: begin a new session there");
}

void add_lacks(const ExplainedSession& s, const MergeConfig& config, std::vector<std::string>& missing) {
  if (!s.complete && s.path_m < config.least_path_m)
    missing.push_back(s.name + text(" is too short: %.0f of %.0f m; it merges when it has come so far, ends, or asks",
                                    s.path_m, config.least_path_m));
  if (s.clouds < s.keyframes)
    missing.push_back(
        s.name +
        text(": %.0f of %.0f clouds are here; ", static_cast<double>(s.clouds), static_cast<double>(s.keyframes)) +
        (s.connected ? "those that are needed were asked for" : "its robot is not connected"));
}

std::vector<std::string> missing_of(const ExplainedSession& a, const ExplainedSession& b, const Alignment& k,
                                    const MergeConfig& config, const SessionNames& names) {
  std::vector<std::string> missing;
  const Evidence& e = k.evidence;
  if (const auto& by = k.objection)
    missing.push_back(
        text("it would lay %s and %s on each other, where the rays of one pass through %.1f %% of what the "
             "other saw: likely a look-alike; when you know better, confirm it",
             names(by->a).c_str(), names(by->b).c_str(), 100 * by->violation));
  if (has_placement(k)) {
    if (e.probability < config.accept_probability)
      missing.push_back(text("the probability is %.3f and must be %.2f", e.probability, config.accept_probability));
    if (runner_up_share(e) >= config.runner_up_share)
      missing.push_back(text(
          "a different placement is nearly as good (its odds are %.2f of this one's, must be below %.2f): drive on "
          "to where the two would differ",
          runner_up_share(e), config.runner_up_share));
    if (e.weakest_hold < held_well)
      missing.push_back("the position along the drift is held by nothing: drive on to a junction or a bend");
    if (e.overlap_m < asked_overlap_m(e))
      missing.push_back(
          text("the mine repeats itself (%.0f other places look the same, %.1f in 100 m of all that is known): %.0f m "
               "shared, %.0f m would tell",
               e.aliases, e.repetition, e.overlap_m, asked_overlap_m(e)));
    if (e.pairs < few_pairs || e.seen_points < few_points)
      missing.push_back("the overlap is small: drive further into the other's map");
    if (violated(e)) missing.push_back("each sees through walls of the other: look-alikes, or something that moved");
  } else {
    missing.push_back("they do not meet as far as they have come, or the place looks too different: drive on");
  }
  add_lacks(a, config, missing);
  add_lacks(b, config, missing);
  return missing;
}

}  // namespace

std::string_view to_string(Speaks speaks) {
  constexpr std::array<std::string_view, 3> names{"for", "against", "neither"};
  return names.at(static_cast<std::size_t>(speaks));
}

Explanation explain(const ExplainedSession& a, const ExplainedSession& b, const Alignment* alignment, bool together,
                    const MergeConfig& config, const SessionNames& names) {
  Explanation out;
  add_troubles(a, out.missing);
  add_troubles(b, out.missing);
  const std::string both = a.name + " and " + b.name;
  if (a.family != b.family) {
    const bool version = a.family.name == b.family.name;
    out.outcome = both + (version ? " can not be compared: the versions of their descriptor family differ"
                                  : " can not be compared: their descriptor families differ");
    out.missing.push_back(
        a.name + " has " + text_of(a.family) + ", " + b.name + " has " + text_of(b.family) +
        (version ? ": run both robots with the same software and files" : ": run both robots with the same family"));
    return out;
  }
  if (!alignment) {
    out.outcome = both + (together ? " are merged through other sessions; the pair itself has not been tried"
                                   : " are not merged: nothing has been tried yet");
    if (together) return out;
    out.missing.push_back("they are tried when a robot comes, ends or has driven on; \"headframe merge\" tries now");
    add_lacks(a, config, out.missing);
    add_lacks(b, config, out.missing);
    return out;
  }
  out.outcome = outcome_of(both, *alignment, together, config);
  if (has_placement(*alignment)) out.findings = findings_of(alignment->evidence);
  out.decision = decision_of(alignment->ruling);
  if (alignment->state == AlignmentState::published) return out;
  const auto missing = missing_of(a, b, *alignment, config, names);
  out.missing.insert(out.missing.end(), missing.begin(), missing.end());
  return out;
}

}  // namespace headframe
