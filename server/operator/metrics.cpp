#include "server/operator/metrics.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "server/operator/session_totals.hpp"

namespace headframe {
namespace {

class Page {
 public:
  void family(const char* name, const char* type, const char* help) {
    name_ = name;
    out_ << "# HELP headframe_" << name << ' ' << help << "\n# TYPE headframe_" << name << ' ' << type << '\n';
  }
  /// labels: {key="value"} or empty. Values must not come from a peer, because they are not escaped.
  template <class Value>
  void sample(Value value, const std::string& labels = {}) {
    out_ << "headframe_" << name_ << labels << ' ' << value << '\n';
  }
  template <class Value>
  void one(const char* name, const char* type, const char* help, Value value) {
    family(name, type, help);
    sample(value);
  }
  std::string text() const { return out_.str(); }

 private:
  std::ostringstream out_;
  const char* name_ = "";
};

std::string label(const char* key, std::string_view value) {
  std::string out = "{";
  out.append(key).append("=\"").append(value).append("\"}");
  return out;
}

void add_effort(Page& page, const MergeEffort& work) {
  page.one("merge_attempts_total", "counter", "Attempts to merge a session.", work.attempts);
  page.family("merge_seconds_total", "counter", "Time spent in attempts, by stage.");
  const std::array<std::pair<const char*, double>, 6> stages{{{"hypotheses", work.stages.hypotheses_ms},
                                                              {"sampling", work.stages.sampling_ms},
                                                              {"registration", work.stages.registration_ms},
                                                              {"verification", work.stages.verification_ms},
                                                              {"atlas", work.stages.atlas_ms},
                                                              {"loop_closures", work.stages.loop_closures_ms}}};
  for (const auto& [stage, ms] : stages) page.sample(ms / 1000, label("stage", stage));
  page.one("merges_withdrawn_total", "counter", "Published merges that later evidence contradicted.", work.withdrawn);
}

/// Counts alignments by state, and by verdict, which depends on the evidence alone.
void add_alignments(Page& page, const AtlasView& view) {
  std::map<AlignmentState, std::size_t> states, verdicts;
  for (const auto state : {AlignmentState::candidate, AlignmentState::provisional, AlignmentState::verified,
                           AlignmentState::published, AlignmentState::retracted, AlignmentState::rejected})
    states[state] = 0;
  for (const auto verdict :
       {AlignmentState::candidate, AlignmentState::provisional, AlignmentState::verified, AlignmentState::rejected})
    verdicts[verdict] = 0;
  for (const AlignmentRow& row : view.alignments) {
    ++states[row.alignment.state];
    ++verdicts[row.alignment.verdict];
  }
  page.family("alignments", "gauge", "Alignments by state.");
  for (const auto& [state, count] : states) page.sample(count, label("state", to_string(state)));
  page.family("verdicts", "gauge", "Alignments by what their evidence alone says.");
  for (const auto& [verdict, count] : verdicts) page.sample(count, label("verdict", to_string(verdict)));
}

void add_links(Page& page, const LinkHealth& links) {
  page.one("robots_held", "gauge", "1 while nothing is acknowledged to robots.", links.hold.empty() ? 0 : 1);
  page.family("link_ends_total", "counter", "Connections of robots that were refused or did not end well.");
  page.sample(links.refused, label("why", "refused"));
  page.sample(links.replaced, label("why", "replaced"));
  page.sample(links.failed, label("why", "failed"));
  page.sample(links.stuck, label("why", "stuck"));
  page.one("link_held_back_total", "counter", "Times that a robot outran the disk and was not read.", links.held_back);
}

}  // namespace

std::string metrics_text(const std::vector<SessionRow>& sessions, const AtlasView& view, const Pending& pending,
                         const Workload& work, const LinkHealth& links, const std::vector<Survey>& surveys,
                         double uptime_s) {
  const SessionTotals totals = totals_of(sessions);
  Page page;
  page.one("uptime_seconds", "gauge", "Since the operator API began.", uptime_s);
  page.one("sessions", "gauge", "Sessions known.", sessions.size());
  page.one("sessions_aside", "gauge", "Sessions that are set aside: not merged until the operator releases them.",
           totals.aside);
  page.one("robots_connected", "gauge", "Robots connected now.", totals.connected);
  page.one("keyframes", "gauge", "Keyframes stored.", totals.keyframes);
  page.one("clouds", "gauge", "Clouds stored.", totals.clouds);
  page.one("backlog_keyframes", "gauge", "Keyframes that robots still have to send, as they said last.",
           totals.backlog);
  page.family("robot_bytes_received_total", "counter", "Bytes from robots since the server began, by kind.");
  page.sample(totals.cloud_bytes, label("kind", "clouds"));
  page.sample(totals.bytes_received - std::min(totals.bytes_received, totals.cloud_bytes),
              label("kind", "keyframes_and_control"));
  page.one("robot_bytes_sent_total", "counter", "Bytes to robots since the server began.", links.sent_bytes);
  page.one("revision", "counter", "Revision of the atlas.", view.atlas.revision);
  page.one("components", "gauge", "Components of the atlas.", view.atlas.components.size());
  add_alignments(page, view);
  page.family("pending", "gauge", "What has still to be done before the atlas is settled.");
  page.sample(pending.attempts, label("kind", "attempts"));
  page.sample(pending.keyframes, label("kind", "keyframes"));
  page.sample(pending.awaited_submaps, label("kind", "awaited_submaps"));
  page.one("waiting_orders", "gauge", "Decisions of the operator that wait for the merge worker.", work.waiting_orders);
  page.one("store_queued_writes", "gauge", "Writes that wait for the disk.", work.queued_writes);
  page.one("store_queued_bytes", "gauge", "Bytes that wait for the disk.", work.queued_bytes);
  page.one("store_durable_writes_total", "counter", "Writes that are on disk.", work.durable_writes);
  page.one("store_failed_writes_total", "counter", "Writes that failed.", work.failed_writes);
  page.family("store_damaged", "gauge", "Rows and clouds found so far that are not what was written.");
  page.sample(work.damaged_keyframes, label("kind", "keyframes"));
  page.sample(work.damaged_clouds, label("kind", "clouds"));
  page.one("store_commits_total", "counter", "Commits to the disk; each makes all writes of a group durable.",
           work.commits);
  page.one("store_commit_seconds_total", "counter", "Time spent in commits.", work.commit_s);
  page.one("merge_work_seconds", "gauge", "Since the merge worker began the piece of work that it is on; 0: none.",
           work.merge_work_s);
  page.one("merge_stuck", "gauge", "1 while one piece of work takes longer than merge.stuck_s.",
           work.merge_stuck.empty() ? 0 : 1);
  page.one("standbys", "gauge", "Other servers that wait to take over should this one die.", work.standbys);
  double worst_m = 0;
  for (const Survey& survey : surveys)
    for (const double residual_m : residuals_m(survey)) worst_m = std::max(worst_m, residual_m);
  page.one("survey_worst_residual_m", "gauge", "The farthest that a control point lies from where its survey puts it.",
           worst_m);
  add_links(page, links);
  add_effort(page, work.effort);
  return page.text();
}

}  // namespace headframe
