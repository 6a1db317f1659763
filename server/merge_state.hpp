#pragma once
// What the merge pipeline keeps, and the details that its page (merge_pipeline.cpp) leaves out.

#include <chrono>
#include <map>
#include <numbers>

#include "server/atlas/merge_graph.hpp"
#include "server/merge_pipeline.hpp"
#include "server/place/hypotheses.hpp"
#include "server/place_book.hpp"
#include "server/registration/verification.hpp"
#include "server/session_frames.hpp"

namespace headframe {

/// Two registrations that end nearer to each other have found the same placement.
inline constexpr double same_placement_m = 2, same_placement_rad = 0.12;

/// How often a session looks like itself elsewhere, and what that was found from.
struct SelfLikeness {
  double path_m = -1;
  std::size_t clouds = 0;
  double aliases = 0;
  double look_alikes = 0;           // see Evidence::look_alikes
  std::vector<KeyframeRef> wanted;  // clouds of spots whose walls look alike, and that nobody has looked at closely
};

struct Session {
  FamilyId family;
  std::vector<Keyframe> keyframes;
  std::vector<double> path_to_m;  // to each keyframe
  bool complete = false;          // no keyframe is expected: it ended, or rests
  SelfLikeness self;
  std::size_t prepared = 0;  // keyframes whose places were made ahead
  std::size_t asked = 0;     // keyframes whose neighbours were asked whether they see the same
  std::uint64_t mark = 0;    // of the first keyframe as it came: the same whenever the session comes

  void add(Keyframe keyframe);
  /// Those that fit none of their neighbours keep their place on the path and nothing else: no walls, no cloud, no yaw.
  void set_aside_odd();
  Eigen::Vector3d middle() const { return keyframes[keyframes.size() / 2].T_local_sensor.translation(); }
  double path_m() const { return path_to_m.empty() ? 0 : path_to_m.back(); }
};

/// Keyframes of a session that lie near another, in the order of the session.
struct Nearby {
  std::vector<Stand> stored;      // whose clouds can speak
  std::vector<Stand> obtainable;  // whose clouds could
};

/// A hypothesis with the keyframes that can speak on it.
struct Case {
  Hypothesis hypothesis;
  Nearby a, b;
};

struct Candidates {
  std::vector<Case> cases;
  std::size_t awaited = 0;  // that wait for clouds
};

/// The middle of where the two meet, in b's frame.
Eigen::Vector3d middle_of_overlap(const Case& c);

/// A hypothesis as it was judged; with rivals the runner-up can be told.
struct Verdict {
  Judgement judgement;
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();  // where the placement was registered first, in b's frame
  std::vector<KeyframeRef> wanted = {};           // clouds that could tell more
};

/// Two sessions, the second laid on the first. Searching, registering and judging are not the same both ways, so which
/// of two is laid on which may not hang on who came first.
struct Laid {
  SessionId a = 0, b = 0;
};

/// Two sessions as they would lie if they were merged by way of others.
struct Nearing {
  SessionId a = 0, b = 0;  // a < b
  Pose T_a_b = Pose::Identity();
};

/// What was found where two sessions without an alignment of their own meet.
struct SeenContact {
  Pose T_a_b = Pose::Identity();
  std::size_t stands = 0;  // keyframes of both that spoke
  Contact contact = Contact::none;
  Judgement judgement;
  bool recorded = false;  // as an alignment, once both were in one component
};

struct MergePipeline::State {
  MergeConfig config;
  SessionFrames frames;  // all that is kept below lies near zero; what goes out lies in the robots' frames
  std::map<SessionId, Session> sessions;
  /// By family and length of q: two robots may call different vectors by one name.
  std::map<std::pair<FamilyId, std::size_t>, std::unique_ptr<DescriptorIndex>> indices;
  std::vector<Alignment> alignments;
  DecisionBook decisions;
  std::vector<SessionId> anchors;  // in the order they were chosen
  Atlas atlas;
  Atlas atlas_given_out;
  std::vector<Alignment> alignments_given_out;
  HypothesisFinder finder;
  PreparedClouds prepared;
  PlaceBook places;
  PlaceBook far_places;  // free space only, as far as the lidars see
  /// What a pair was judged on last, by ids in order: it is judged again only when there is more.
  std::map<std::pair<SessionId, SessionId>, std::vector<std::size_t>> judged_on;
  std::map<std::pair<SessionId, SessionId>, std::vector<SeenContact>> contacts;  // the latest placements of each pair

  explicit State(const MergeConfig& c);

  /// The report, the atlas and the alignments in the robots' frames; an early return that changed nothing needs it not.
  AttemptReport given_out(AttemptReport report);
  /// Of a session that is set aside; its alignments stay in the list, where their numbers are.
  void forget(SessionId id);
  /// They stand again as their verdict and the operator's word say.
  void wake_alignments(SessionId id);
  /// Alignments and decisions as they were given out once.
  void take_back(std::vector<Alignment> stored, std::vector<DecisionRecord> decided);

  /// The longer on the shorter: it is laid piece by piece, and more pieces find more. (With the shorter of the campus
  /// drives laid on the longer, the search missed the right placement at 4 of 24 turns, else at none.)
  Laid laid(SessionId one, SessionId other) const;
  void merge_pair(const Laid& pair, CloudSource& clouds, AttemptReport& report);
  /// The verdict on a placement that is trusted to within a metre or two.
  Judgement judge_placement(const Laid& pair, const Pose& T_a_b, CloudSource& clouds);
  bool still_holds(Alignment& published, CloudSource& clouds, AttemptReport& report);
  /// Path in metres that a session which still grows has to come along before a placement is told, after
  /// MergeConfig::shown_m; 0: none, or both are complete.
  double path_awaited_m(const Laid& pair, const Pose& T_a_b, double shared_m) const;
  /// Both are complete, and at least one was not when the pair was judged as a whole.
  bool ended_since_judged(const Alignment& known) const;
  void record(const Laid& pair, const Judgement& judged, const std::optional<Pose>& T_runner_up, bool waits,
              AttemptReport& report);
  /// Looks where sessions that alignments would bring together meet. Those that agree become alignments themselves.
  void look_at_contacts(CloudSource& clouds, AttemptReport& report);
  /// Nothing where they do not come near each other; unknown where nobody has looked.
  std::optional<Contact> known_contact(const Nearing& nearing);
  MergeResult merge(const Contacts& contacts) const;
  std::optional<Objection> objection_of(const std::optional<std::pair<SessionId, SessionId>>& pair) const;
  void update_atlas(AttemptReport& report);

  /// Sessions of the same family, those whose descriptors look most alike first.
  std::vector<SessionId> partners(SessionId id) const;
  Case make_case(SessionId a, SessionId b, const Hypothesis& hypothesis, const CloudSource& clouds);
  /// The hypotheses that can be judged now; for the first of the others clouds are asked for.
  Candidates look_for_clouds(const Laid& pair, const std::vector<Hypothesis>& hypotheses, const Alignment* known,
                             const CloudSource& clouds, AttemptReport& report);
  /// What the verdicts want, the best first. True: the best would be believed but for what it wants.
  bool ask_for_more(const Laid& pair, const std::vector<Verdict>& verdicts, std::size_t awaited,
                    const CloudSource& clouds, AttemptReport& report);
  /// Of the clouds that can be had, those around the spot where the hypothesis is looked at first.
  std::vector<KeyframeRef> wanted_to_look(const Laid& pair, const Case& c) const;
  /// More of those of the overlap, from that spot on, if they could make it believed.
  std::vector<KeyframeRef> wanted_to_tell(const Laid& pair, const Case& c, const Verdict& verdict) const;
  Scene scene(SessionId id, std::vector<Stand> stands, CloudSource& clouds);
  /// Copies that a session's mine shows of itself. Looked for again when the session, or what is stored of its clouds,
  /// has grown by a quarter.
  double self_aliases(SessionId id, CloudSource& clouds);
  /// The same placement of a session on itself, looked at 15 m before and behind along its path.
  std::vector<Case> beside(SessionId id, const Hypothesis& hypothesis, const CloudSource& clouds);
  /// How many of these placements of a session on itself, other than where it lies, are copies 15 m long and more:
  /// their first place looks right by itself, and so does one of those beside it.
  int copies_within(SessionId id, const std::vector<Glance>& glances, CloudSource& clouds);
  /// Of what is known of that so far; see Evidence::repetition. Of less than 500 m little can be said, and of sessions
  /// that have yet to be looked at nothing.
  double repetition() const;
  /// Glances at all, in parallel.
  std::vector<Glance> glance_at(SessionId a, SessionId b, const std::vector<Case>& cases, CloudSource& clouds);
  /// The hopeful ones that differ are judged; those that could not cast doubt on a better one only when all are asked
  /// for. Best first.
  std::vector<Verdict> judge_cases(SessionId a, SessionId b, const std::vector<Case>& cases, CloudSource& clouds,
                                   bool all, AttemptReport& report);
  /// Evidence::farther_violation, where all clouds around are stored; those that could be are wanted. Takes some 20 ms
  /// for each 4 m of shared path, so it is asked last.
  void look_farther(const Laid& pair, const Case& c, Verdict& verdict, CloudSource& clouds);
  static PlaceConfig far_places_config();
  /// Makes one of the places that a merge may need; false: there is none left to make.
  bool prepare_ahead(CloudSource& clouds);
  bool self_likeness_known(SessionId id, const CloudSource& clouds) const;
  /// Of the two, whichever comes first; null: none.
  Alignment* find(SessionId one, SessionId other);
  void index_keyframe(SessionId id, const Keyframe& keyframe);
  /// A few metres of drift look like many others: a growing session waits until it has seen more.
  bool may_merge(SessionId id) { return sessions[id].complete || sessions[id].path_m() >= config.least_path_m; }
  bool worth_clouds(const Laid& pair) { return may_merge(pair.a) && may_merge(pair.b); }
  JudgeConfig judge_config() const;

 private:
  SeenContact* seen_contact(const Nearing& nearing);
  bool look_at(const Nearing& nearing, CloudSource& clouds, AttemptReport& report);
  bool record_agreeing(const MergeResult& merged, AttemptReport& report);
  Nearby nearby(SessionId id, SessionId other, const Pose& T_id_other, const CloudSource& clouds) const;
  void ask(SessionId id, std::vector<Stand> obtainable, const Eigen::Vector3d& p, std::size_t most,
           std::vector<KeyframeRef>& wanted) const;
  PlaceRequest place_at(SessionId id, std::size_t keyframe) const;
};

/// T_a_b of a pair as laid, or its inverse where the ids of the two are the other way round: alignments have a < b. It
/// works both ways.
Pose by_ids(const Laid& pair, const Pose& T);
Judgement by_ids(const Laid& pair, Judgement judgement);

/// Sum of the likeness of these, each placement once and those near `T` left out.
double look_alikes(std::vector<Glance> glances, const Pose& T);

/// Fills in what the descriptors say of the judged placement.
void compare_descriptors(const DescriptorAgreement& agreement, Judgement& judgement);

/// Adds the time of a scope to a total.
class Stopwatch {
 public:
  explicit Stopwatch(double& total_ms) : total_ms_(total_ms) {}
  ~Stopwatch() { total_ms_ += ms_since(start_); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_ms_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Whether two placements put p more than so many metres, or turn more than so many radians, apart.
inline bool differ(const Pose& T, const Pose& U, const Eigen::Vector3d& p, double metres, double radians) {
  return (T * p - U * p).norm() > metres || rotation_angle_rad(T.inverse() * U) > radians;
}

}  // namespace headframe
