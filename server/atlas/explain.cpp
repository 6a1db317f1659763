#include "server/atlas/explain.hpp"

#include <cmath>
#include <numbers>

#include "server/atlas/formatted.hpp"

namespace headframe {
namespace {

std::string text_of(const FamilyId& family) { return family.name + " version " + std::to_string(family.version); }

std::string placement_of(const Alignment& k) {
  const Eigen::Vector3d t = k.T_a_b.translation();
  return formatted("at x %.1f, y %.1f, z %.1f m, turned by %.1f deg, with probability %.3f", t.x(), t.y(), t.z(),
                   yaw_rad(k.T_a_b) * 180 / std::numbers::pi, k.evidence.probability);
}

std::string decision_of(Ruling ruling) {
  switch (ruling) {
    case Ruling::confirmed: return "confirmed by the operator: it stays whatever the evidence says";
    case Ruling::refused: return "refused by the operator: not proposed again until there is twice the evidence";
    case Ruling::retracted: return "retracted by the operator: not proposed again until there is twice the evidence";
    case Ruling::placed: return "placed by the operator: it is not merged until it is confirmed, or found by itself";
    case Ruling::none: break;
  }
  return {};
}

std::string outcome_of(const std::string& both, const Alignment& k, bool together, const VerdictThresholds& config) {
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
    case AlignmentState::provisional: return apart + "it looks right, and is provisional while a robot drives" + best;
    case AlignmentState::candidate:
      return apart +
             (convinces(k.evidence, config) ? "it looks right, and waits" : "it may be right, but is not sure enough") +
             best;
    case AlignmentState::rejected:
    case AlignmentState::published: break;
  }
  return apart + "nothing stands up" + best;
}

std::string site_text(const ExplainedSession& s) {
  return s.name + " is of " + (s.site.empty() ? "no site" : "the site " + s.site);
}

/// What speaks of one session whatever became of the pair.
void add_troubles(const ExplainedSession& s, std::vector<std::string>& missing) {
  if (s.archived) missing.push_back(s.name + " is archived: headframe session restore brings it back");
  if (!s.why_aside.empty())
    missing.push_back(s.name + " is set aside (" + s.why_aside + "): headframe session release takes it back");
  if (!s.why_cut.empty()) missing.push_back(s.name + ": " + s.why_cut);
}

void add_lacks(const ExplainedSession& s, const VerdictThresholds& config, std::vector<std::string>& missing) {
  if (!s.complete && s.path_m < config.least_path_m)
    missing.push_back(s.name +
                      formatted(" is too short: %.0f of %.0f m; it merges when it has come so far, ends, or asks",
                                s.path_m, config.least_path_m));
  if (s.clouds < s.keyframes)
    missing.push_back(
        s.name +
        formatted(": %.0f of %.0f clouds are here; ", static_cast<double>(s.clouds), static_cast<double>(s.keyframes)) +
        (s.connected ? "those that are needed were asked for" : "its robot is not connected"));
}

/// The two terms that cost most.
void add_costliest(const Evidence& e, const VerdictThresholds& config, std::vector<std::string>& missing) {
  const std::vector<Finding> findings = findings_of(e, config);
  for (std::size_t i = 0; i < std::min<std::size_t>(2, findings.size()); ++i)
    if (findings[i].speaks == Speaks::against)
      missing.push_back(
          findings[i].text +
          formatted(": without this the probability would be %.3f", probability_without(findings[i], e, config)) +
          (findings[i].would_suffice.empty() ? "" : "; " + findings[i].would_suffice));
}

std::vector<std::string> missing_of(const ExplainedSession& a, const ExplainedSession& b, const Alignment& k,
                                    const VerdictThresholds& config, const SessionNames& names) {
  std::vector<std::string> missing;
  const Evidence& e = k.evidence;
  if (const auto& by = k.objection)
    missing.push_back(
        formatted("it would lay %s and %s on each other, where the rays of one pass through %.1f %% of what the "
                  "other saw: likely a look-alike; when you know better, confirm it",
                  names(by->a).c_str(), names(by->b).c_str(), 100 * by->violation));
  if (has_placement(k)) {
    if (e.probability < config.accept_probability) {
      missing.push_back(
          formatted("the probability is %.3f and must be %.2f", e.probability, config.accept_probability));
      add_costliest(e, config, missing);
      if (e.probability_if_unique >= config.accept_probability)
        missing.push_back(
            formatted("nothing but its likeness to other places speaks against it (else the probability would be "
                      "%.3f): when you know the place, confirm or refuse it",
                      e.probability_if_unique));
    }
    if (runner_up_share(e) >= config.runner_up_share)
      missing.push_back(formatted(
          "a different placement is nearly as good (its odds are %.2f of this one's, must be below %.2f): drive on "
          "to where the two would differ",
          runner_up_share(e), config.runner_up_share));
    if (e.awaited_m > 0)
      missing.push_back(
          formatted("more path may contradict a look-alike: %.0f m are awaited, of a robot that still drives (of this "
                    "pair or, where places look alike, another; its end tells, too) or of a drive that was short",
                    e.awaited_m));
    if (e.weakest_hold < held_well)
      missing.push_back("the position along the tunnel is held by nothing: drive on to a junction or a bend");
    if (e.aliases > 0 && e.probability < config.accept_probability)
      missing.push_back("drive further together than the copies are long");
  } else {
    missing.push_back("they do not meet as far as they have come, or the place looks too different: drive on");
  }
  add_lacks(a, config, missing);
  add_lacks(b, config, missing);
  if (a.family != b.family)
    missing.push_back("descriptors that can be compared: " + a.name + " has " + text_of(a.family) + ", " + b.name +
                      " has " + text_of(b.family) +
                      ", so walls and rock alone tell; give both robots the same family and software");
  return missing;
}

}  // namespace

Explanation explain(const ExplainedSession& a, const ExplainedSession& b, const Alignment* alignment, bool together,
                    const VerdictThresholds& config, const SessionNames& names) {
  Explanation out;
  add_troubles(a, out.missing);
  add_troubles(b, out.missing);
  if (a.site != b.site && !together)
    out.missing.push_back(site_text(a) + ", " + site_text(b) +
                          ": they are never tried; headframe site says where they were driven, and headframe place "
                          "lays one on the other all the same");
  const std::string both = a.name + " and " + b.name;
  if (!alignment) {
    out.outcome = both + (together ? " are merged through other sessions; the pair itself has not been tried"
                                   : " are not merged: nothing has been tried yet");
    if (together) return out;
    if (a.site == b.site)
      out.missing.push_back("they are tried when a robot comes, ends or has driven on; \"headframe merge\" tries now");
    add_lacks(a, config, out.missing);
    add_lacks(b, config, out.missing);
    return out;
  }
  out.outcome = outcome_of(both, *alignment, together, config);
  if (has_placement(*alignment)) {
    out.findings = findings_of(alignment->evidence, config);
    out.gates = gates_of(*alignment, config);
  }
  out.decision = decision_of(alignment->ruling);
  if (alignment->state == AlignmentState::published) return out;
  const auto missing = missing_of(a, b, *alignment, config, names);
  out.missing.insert(out.missing.end(), missing.begin(), missing.end());
  return out;
}

std::string why_withdrawn(const Alignment& now) {
  if (now.ruling == Ruling::retracted) return "the operator took it back";
  switch (now.state) {
    case AlignmentState::verified: return "other sessions contradict it";
    case AlignmentState::candidate:
    case AlignmentState::provisional: return "it is no longer sure enough";
    case AlignmentState::retracted:
    case AlignmentState::rejected:
    case AlignmentState::published: break;
  }
  return "later evidence contradicts it";
}

}  // namespace headframe
