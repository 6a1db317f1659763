// What an operator does with sessions over the years: archived ones are kept but left out of everything, frozen ones
// serve as reference.

#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/merge_worker/merge_worker.hpp"

namespace headframe {

/// Brings back a session that was left out; its alignments apply again, all in one write.
Result<void> MergeWorker::bring_in_again(SessionId session, PutMerge write) {
  const auto sessions = store_.sessions();
  if (!sessions) return tl::unexpected(sessions.error());
  auto merge = store_.merge();
  if (!merge) return tl::unexpected(merge.error());
  for (const SessionRecord& record : *sessions) {
    if (record.id != session) continue;
    bring_in(record);
    if (!record.complete && !settled(record)) schedule_.grows(session, Clock::now());
  }
  if (is_aside(session)) return failure(ErrorCode::internal, troubles_.at(session).why_aside);
  for (const PairClosures& known : merge->closures)
    if (known.a == session || known.b == session) pipeline_->restore_closures(known);
  std::erase_if(merge->self_likeness, [&](const auto& entry) { return entry.first != session; });
  pipeline_->restore_self_likeness(merge->self_likeness);
  if (!commit(std::move(write), pipeline_->come_back(session), nullptr))
    return failure(ErrorCode::unavailable, stop_reason_);
  const auto is_this = [&](const SessionRecord& record) { return record.id == session; };
  const auto record = std::find_if(sessions->begin(), sessions->end(), is_this);
  catch_up(session, record != sessions->end() && record->complete);
  schedule_.trigger(session, Trigger::command, Clock::now());
  if (known_[session].asks_where) take_question(session, true);
  update_view();
  return {};
}

Result<void> MergeWorker::put_archived(SessionId session, bool archived) {
  if (!known_.contains(session)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(session));
  if (archived_.contains(session) == archived)
    return failure(ErrorCode::refused, archived ? "the session is archived already" : "the session is not archived");
  PutMerge write;
  write.archived = PutArchived{session, archived};
  if (!archived) archived_.erase(session);
  const bool stays_out = is_aside(session);  // for another reason
  if (archived) archived_.insert(session);
  Result<void> done;
  if (stays_out)
    done = write_durably(write) ? Result<void>() : failure(ErrorCode::unavailable, stop_reason_);
  else
    done = archived ? leave_out(session, std::move(write)) : bring_in_again(session, std::move(write));
  if (!done) return done;
  update_view();
  spdlog::info("session {} is {}", session, archived ? "archived" : "restored");
  return {};
}

Result<void> MergeWorker::put_frozen(SessionId session, bool frozen) {
  if (!known_.contains(session)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(session));
  if (is_aside(session))
    return failure(ErrorCode::refused, archived_.contains(session) ? "the session is archived; restore it first"
                                                                   : "the session is set aside; release it first");
  const auto report = frozen ? pipeline_->freeze(session) : pipeline_->thaw(session);
  if (!report) return tl::unexpected(report.error());
  frozen ? (void)frozen_.insert(session) : (void)frozen_.erase(session);
  if (!commit({}, *report, nullptr)) return failure(ErrorCode::unavailable, stop_reason_);
  if (!frozen) catch_up(session, false);
  update_view();
  spdlog::info("session {} is {}; revision {}", session, frozen ? "frozen" : "thawed", atlas_.revision);
  return {};
}

Result<void> MergeWorker::put_site(SessionId session, const std::string& site) {
  const auto known = known_.find(session);
  if (known == known_.end()) return failure(ErrorCode::not_found, "there is no session " + std::to_string(session));
  if (known->second.site == site) return {};
  PutMerge write;
  write.site = PutSite{session, site};
  known->second.site = site;
  const bool done =
      is_aside(session) ? write_durably(write) : commit(std::move(write), pipeline_->set_site(session, site), nullptr);
  if (!done) return failure(ErrorCode::unavailable, stop_reason_);
  if (!is_aside(session)) schedule_.trigger(session, Trigger::command, Clock::now());
  update_view();
  spdlog::info("session {} is {}", session, site.empty() ? "of no site" : "of the site " + site);
  return {};
}

void MergeWorker::set_site(SessionId session, const std::string& site, std::function<void(const Result<void>&)> done) {
  give([this, session, site, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? put_site(session, site) : admitted);
  });
}

void MergeWorker::archive(SessionId session, bool archived, std::function<void(const Result<void>&)> done) {
  give([this, session, archived, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? put_archived(session, archived) : admitted);
  });
}

void MergeWorker::freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> done) {
  give([this, session, frozen, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? put_frozen(session, frozen) : admitted);
  });
}

}  // namespace headframe
