#include "server/merge/localize.hpp"

#include <algorithm>

#include "server/atlas/support.hpp"
#include "server/session/same_placement.hpp"

namespace headframe {
namespace {

constexpr double rival_share = 0.1;  // of the best placement's odds, from which on a rival prevents an answer

bool is_of(const Alignment& alignment, SessionId id) { return alignment.a == id || alignment.b == id; }
SessionId other_of(const Alignment& alignment, SessionId id) { return alignment.a == id ? alignment.b : alignment.a; }

const Component* component_of(const Atlas& atlas, SessionId session) {
  const auto found = std::find_if(atlas.components.begin(), atlas.components.end(),
                                  [&](const Component& c) { return placement_in(c, session) != nullptr; });
  return found == atlas.components.end() ? nullptr : &*found;
}

Eigen::Matrix<double, 6, 6> covariance_of(const Evidence& e) {
  const MergeDeviation deviation = deviation_of(e);
  Eigen::Matrix<double, 6, 1> variances;
  variances << Eigen::Vector3d::Constant(deviation.metres * deviation.metres),
      Eigen::Vector3d::Constant(deviation.radians * deviation.radians);
  return variances.asDiagonal();
}

/// One question, answered from the state after the last attempt.
class Question {
 public:
  Question(SessionId id, const SessionMap& sessions, const AlignmentBook& book, const Contacts& contacts)
      : id_(id), sessions_(sessions), book_(book), contacts_(contacts), newest_(sessions.at(id).keyframes.back()) {
    out_.keyframe = newest_.sequence;
  }

  SessionLocalization answer() {
    const Alignment* best = likeliest();
    if (best) describe(*best);
    const Component* mine = component_of(book_.atlas_given_out(), id_);
    if (mine && mine->placements.size() > 1) {
      out_.merged = true;
      return found(*mine, placement_in(*mine, id_)->T_component_session);
    }
    if (!best) return not_yet(nothing_found());
    const Component* map = component_of(book_.atlas_given_out(), out_.on);
    if (!map) return not_yet("its place is not in the atlas yet");
    if (std::string why = doubts(*best, *map); !why.empty()) return not_yet(why);
    return found(*map, T_component_session(*best, *map));
  }

 private:
  /// The most probable alignment with a placement; merged ones come first.
  const Alignment* likeliest() const {
    const Alignment* best = nullptr;
    const auto rank = [](const Alignment& k) {
      return std::pair(k.state == AlignmentState::published, k.evidence.probability);
    };
    for (const Alignment& k : book_.alignments_given_out())
      if (is_of(k, id_) && usable(k) && (!best || rank(k) > rank(*best))) best = &k;
    return best;
  }

  /// What the operator refused or retracted does not count.
  bool usable(const Alignment& k) const {
    return has_placement(k) && sessions_.contains(k.a) && sessions_.contains(k.b) && k.ruling != Ruling::refused &&
           k.ruling != Ruling::retracted && k.evidence.probability >= book_.config().candidate_probability;
  }

  void describe(const Alignment& best) {
    const Evidence& e = best.evidence;
    out_.on = other_of(best, id_);
    out_.probability = e.probability;
    out_.shared_m = e.overlap_m;
    out_.look_alikes = e.similar_places + e.aliases;
    out_.covariance = covariance_of(e);
    const OrderedPair pair{best.a, best.b};
    out_.awaited_m = sessions_.path_awaited_to_localize_m(id_, pair, local(best.a, best.b, best.T_a_b), e);
  }

  Pose local(SessionId a, SessionId b, const Pose& T_a_b) const { return sessions_.frames().local(a, b, T_a_b); }

  Pose T_component_session(const Alignment& k, const Component& map) const {
    const Pose T_other_session = k.a == id_ ? k.T_a_b.inverse() : k.T_a_b;
    return placement_in(map, other_of(k, id_))->T_component_session * T_other_session;
  }

  std::string doubts(const Alignment& best, const Component& map) const {
    if (!convinces(best.evidence, book_.config()))
      return book_.waits_for_clouds(best.id) ? "the likeliest place waits for clouds of its surroundings"
                                             : "the likeliest place is not sure enough: drive on";
    if (book_.waits_for_clouds(best.id)) return "it waits for clouds that may tell the place from others";
    if (best.objection) return "where it would be the sessions of the map contradict each other";
    if (has_rival(best, map)) return "other places are nearly as likely: drive on to where they differ";
    if (contradicted(best, map)) return "another session of the map saw something else there";
    if (out_.awaited_m > 0)
      return "places like this one may be elsewhere too: drive on for " +
             std::to_string(static_cast<long>(std::ceil(out_.awaited_m))) + " m";
    return "";
  }

  /// Whether there is another placement, on another session, that is too probable to be ignored. If that session is not
  /// merged with this map, it cannot be known to be the same place, so it counts as a rival.
  bool has_rival(const Alignment& best, const Component& map) const {
    const Pose T = T_component_session(best, map);
    const Eigen::Vector3d here = newest_.T_local_sensor.translation() + sessions_.frames().origin_m(id_);
    const auto& all = book_.alignments_given_out();
    return std::any_of(all.begin(), all.end(), [&](const Alignment& k) {
      if (!is_of(k, id_) || k.id == best.id || !usable(k)) return false;
      if (odds(k.evidence.probability) < rival_share * odds(best.evidence.probability)) return false;
      return !placement_in(map, other_of(k, id_)) ||
             !same_placement(T, T_component_session(k, map), here, same_as_rival);
    });
  }

  bool contradicted(const Alignment& best, const Component& map) const {
    const Pose T = T_component_session(best, map);
    return std::any_of(map.placements.begin(), map.placements.end(), [&](const Placement& p) {
      if (p.session == other_of(best, id_) || p.session == id_ || !sessions_.contains(p.session)) return false;
      const auto [a, b] = std::minmax(id_, p.session);
      const Pose T_id_p = T.inverse() * p.T_component_session;
      return contacts_(a, b, local(a, b, a == id_ ? T_id_p : T_id_p.inverse())) == Contact::contradicts;
    });
  }

  std::string nothing_found() const {
    const auto maps = std::count_if(sessions_.all().begin(), sessions_.all().end(), [&](const auto& entry) {
      return entry.first != id_ && !entry.second.keyframes.empty() && sessions_.may_merge(entry.first);
    });
    if (maps == 0) return "nobody has mapped anything yet";
    return "nothing that was seen so far is in the map: drive on";
  }

  SessionLocalization found(const Component& map, const Pose& T_component_session) {
    out_.found = true;
    out_.awaited_m = 0;
    out_.component = map.id;
    if (out_.on == 0) out_.on = map.id;
    out_.T_component_session = T_component_session;
    const Pose T_local_sensor = Eigen::Translation3d(sessions_.frames().origin_m(id_)) * newest_.T_local_sensor;
    out_.T_component_sensor = T_component_session * T_local_sensor;
    return out_;
  }

  SessionLocalization not_yet(std::string why) {
    out_.missing = std::move(why);
    out_.covariance.setZero();
    return out_;
  }

  const SessionId id_;
  const SessionMap& sessions_;
  const AlignmentBook& book_;
  const Contacts& contacts_;
  const Keyframe& newest_;
  SessionLocalization out_;
};

}  // namespace

bool SessionLocalization::operator==(const SessionLocalization& other) const {
  return found == other.found && merged == other.merged && component == other.component && on == other.on &&
         keyframe == other.keyframe && T_component_session.matrix() == other.T_component_session.matrix() &&
         T_component_sensor.matrix() == other.T_component_sensor.matrix() && covariance == other.covariance &&
         probability == other.probability && shared_m == other.shared_m && awaited_m == other.awaited_m &&
         look_alikes == other.look_alikes && missing == other.missing;
}

SessionLocalization localize(SessionId id, const SessionMap& sessions, const AlignmentBook& book,
                             const Contacts& contacts) {
  if (!sessions.contains(id) || sessions.at(id).keyframes.empty())
    return {.missing = "no keyframe of this session is here yet"};
  return Question(id, sessions, book, contacts).answer();
}

}  // namespace headframe
