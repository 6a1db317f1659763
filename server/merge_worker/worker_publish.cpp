// The changes of attempts and of the operator: first stored, then published.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/atlas/explain.hpp"
#include "server/atlas/support.hpp"
#include "server/merge_worker/merge_worker.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {
namespace {

constexpr auto retry_after = std::chrono::seconds(1);  // after a failed write: the disk may have room again

}  // namespace

Result<void> MergeWorker::carry_out(AlignmentId id, Decision decision) {
  const auto report = pipeline_->decide(id, decision);
  if (!report) return tl::unexpected(report.error());
  if (!commit({}, *report, nullptr)) return failure(ErrorCode::unavailable, stop_reason_);
  spdlog::info("the operator's decision on alignment {}: {}; revision {}", id, to_string(decision), atlas_.revision);
  for (const Alignment& alignment : report->changed)  // results that a decision had suppressed can be found again
    if (decision == Decision::undo && alignment.id == id)
      schedule_.trigger(alignment.b, Trigger::command, std::chrono::steady_clock::now());
  return {};
}

Result<void> MergeWorker::carry_out_anchor(SessionId session) {
  const auto report = pipeline_->anchor(session);
  if (!report) return tl::unexpected(report.error());
  if (!commit({}, *report, nullptr)) return failure(ErrorCode::unavailable, stop_reason_);
  spdlog::info("the operator made session {} its component's anchor; revision {}", session, atlas_.revision);
  return {};
}

/// attempt: the cause of the change; null if it was the operator's decision, or a robot's SLAM (write.moved). Returns
/// false if the server stops.
bool MergeWorker::commit(PutMerge write, const AttemptReport& report, const MergeSchedule::Attempt* attempt) {
  write.changed = report.changed;
  write.decided = report.decided;
  write.anchored = report.anchored;
  write.closures = report.closures;
  write.self_likeness = report.self_likeness;
  write.frozen = report.frozen;
  write.thawed = report.thawed;
  if (report.atlas_changed) write.atlas = pipeline_->atlas();
  const bool news = write.attempted != 0 || !write.changed.empty() || !write.decided.empty() || write.anchored != 0 ||
                    !write.self_likeness.empty() || !write.closures.empty() || !write.frozen.empty() ||
                    write.thawed != 0 || write.trouble || write.archived || write.site || write.moved;
  if ((news || write.atlas) && !write_durably(write)) return false;
  const bool by_operator = !attempt && !write.moved;
  if (report.atlas_changed || report.provisional_changed) {
    std::vector<Withdrawal> withdrawn = withdrawn_by(report);
    if (write.moved)
      for (Withdrawal& w : withdrawn) w.reason = "a robot's SLAM moved where it had been, and " + w.reason;
    published(report, attempt, withdrawn);
    if (report.atlas_changed && !by_operator) note_withdrawn(withdrawn);
  }
  if (report.atlas_changed || report.provisional_changed || !report.closures.empty() || !report.changed.empty())
    update_view();
  return true;
}

void MergeWorker::published(const AttemptReport& report, const MergeSchedule::Attempt* attempt,
                            const std::vector<Withdrawal>& withdrawn) {
  const Atlas before = std::exchange(atlas_, pipeline_->atlas());
  add_supports(atlas_, pipeline_->alignments());
  const auto changed = changed_components(before, atlas_);
  if (report.atlas_changed) robots_->publish(atlas_, changed, withdrawn);
  if (report.provisional_changed) robots_->tell_provisional(atlas_, changed_provisionals(before, atlas_));
  if (!report.atlas_changed || !attempt) return;
  const double ms = ms_since(attempt->triggered);
  for (const Component& component : changed)
    for (const Placement& placement : component.placements) {
      double& known_ms = draft_.sessions[placement.session].trigger_to_transform_ms;
      if (placement.session == attempt->session || known_ms < 0) known_ms = ms;
    }
  spdlog::info("revision {}: session {}, {:.0f} ms from its trigger ({}) to the transform; {} components changed",
               atlas_.revision, attempt->session, ms, to_string(attempt->trigger), changed.size());
}

/// Alignments that the view still shows as published and that the report withdraws.
std::vector<Withdrawal> MergeWorker::withdrawn_by(const AttemptReport& report) const {
  std::vector<Withdrawal> withdrawn;
  for (const Alignment& now : report.changed) {
    const auto was =
        std::find_if(draft_.alignments.begin(), draft_.alignments.end(), [&](const auto& k) { return k.id == now.id; });
    if (was != draft_.alignments.end() && was->state == AlignmentState::published &&
        now.state != AlignmentState::published)
      withdrawn.push_back({now.a, now.b, why_withdrawn_of(now)});
  }
  return withdrawn;
}

std::string MergeWorker::why_withdrawn_of(const Alignment& now) const {
  if (archived_.contains(now.a) || archived_.contains(now.b)) return "one of the two was archived";
  if (known_.at(now.a).site != known_.at(now.b).site) return "one of the two was driven at another site";
  return why_withdrawn(now);
}

/// A robot may have relied on it, so a withdrawal is always logged.
void MergeWorker::note_withdrawn(const std::vector<Withdrawal>& withdrawn) {
  for (const Withdrawal& w : withdrawn) {
    spdlog::error("a published merge is withdrawn: sessions {} and {}: {}", w.a, w.b, w.reason);
    const std::lock_guard lock(mutex_);
    ++effort_.withdrawn;
  }
}

/// Blocks until the write is durable, trying again while the disk is full or slow. Returns false if the server stops,
/// or if the write is impossible; then merging stops.
bool MergeWorker::write_durably(const Write& write) {
  no_work();  // time spent on the disk does not count against the sessions
  while (true) {
    auto result = std::make_shared<std::optional<Result<void>>>();
    store_.write(write, [bell = bell_, result](const Result<void>& done) {
      const std::lock_guard lock(bell->mutex);
      *result = done;
      bell->wake.notify_all();
    });
    std::unique_lock lock(mutex_);
    wake_.wait(lock, [&] { return result->has_value() || stopping_; });
    if (!result->has_value()) return false;
    if (result->value()) return true;
    const Error& why = result->value().error();
    if (why.code != ErrorCode::unavailable) {  // would fail again each time
      stop_reason_ = "merging has stopped until the server is started anew: " + why.message;
      spdlog::error("{}", stop_reason_);
      stopping_ = true;
      return false;
    }
    spdlog::error("the merge waits for the disk: {}", why.message);
    if (wake_.wait_for(lock, retry_after, [&] { return stopping_; })) return false;
  }
}

}  // namespace headframe
