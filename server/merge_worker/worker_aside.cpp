// Sessions that are set aside: by the operator, or because work on them repeatedly ended the server. Everything else
// goes on without them; their robots are served as before, and no data is lost until the operator deletes it.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <tuple>

#include "server/merge_worker/merge_worker.hpp"

namespace headframe {
namespace {

constexpr int most_deaths = 2;  // then a session is set aside
constexpr int most_kills = 5;   // a server may be killed for other reasons

std::string why_aside(const TroubleRecord& trouble) {
  if (trouble.deaths >= most_deaths)
    return "work on it failed, hung or ended the server " + std::to_string(trouble.deaths) + " times running";
  return "the server was killed during work on it " + std::to_string(trouble.kills) + " times running";
}

bool beyond_bearing(const TroubleRecord& trouble) {
  return trouble.deaths >= most_deaths || trouble.kills >= most_kills;
}

}  // namespace

void MergeWorker::working_on(SessionId a, SessionId b) {
  if (mark_) mark_->on(a, b);
  watch_.on(a, b);
}

void MergeWorker::no_work() {
  if (mark_) mark_->off();
  watch_.off();
}

std::string MergeWorker::stuck() const { return why_stuck(watch_.piece(), std::chrono::steady_clock::now(), stuck_s_); }

bool MergeWorker::is_aside(SessionId session) const {
  const auto found = troubles_.find(session);
  return archived_.contains(session) || (found != troubles_.end() && !found->second.why_aside.empty());
}

/// Reads the stored records, and blames the sessions that the last process died on.
Result<void> MergeWorker::restore_troubles() {
  const auto stored = store_.troubles();
  if (!stored) return tl::unexpected(stored.error());
  for (const TroubleRecord& trouble : *stored) troubles_[trouble.session] = trouble;
  if (!mark_ || mark_->left().end == WorkMark::End::well) return {};
  const auto sessions = store_.sessions();
  if (!sessions) return tl::unexpected(sessions.error());
  const auto known = [&](SessionId id) {
    return std::any_of(sessions->begin(), sessions->end(), [&](const SessionRecord& s) { return s.id == id; });
  };
  const WorkMark::Left& left = mark_->left();
  if (known(left.a) && known(left.b)) blame(left);
  return {};
}

/// Of two sessions that were worked on together, sets aside the one with more deaths, or else the later one.
void MergeWorker::blame(const WorkMark::Left& left) {
  TroubleRecord* worst = &troubles_[left.a];
  for (const SessionId id : std::set<SessionId>{left.a, left.b}) {
    TroubleRecord& trouble = troubles_[id];
    trouble.session = id;
    ++(left.end == WorkMark::End::died ? trouble.deaths : trouble.kills);
    const auto rank = [](const TroubleRecord& t) { return std::tuple(t.deaths, t.kills, t.session); };
    if (rank(*worst) < rank(trouble)) worst = &trouble;
  }
  if (beyond_bearing(*worst) && worst->why_aside.empty()) {
    worst->why_aside = why_aside(*worst);
    spdlog::error("session {} is set aside: {}; `headframe session release` takes it back", worst->session,
                  worst->why_aside);
  }
  for (const SessionId id : std::set<SessionId>{left.a, left.b}) (void)write_durably(PutTrouble{troubles_[id]});
}

/// Work that threw or used up its budget counts against the sessions it was on.
void MergeWorker::work_failed() {
  const auto piece = watch_.piece();
  if (!piece) return;
  no_work();
  blame({piece->a, piece->b, WorkMark::End::died});
  for (const SessionId id : std::set<SessionId>{piece->a, piece->b})
    if (is_aside(id)) (void)leave_out(id, {});
}

void MergeWorker::attempt_went_well(SessionId session) {
  const auto found = troubles_.find(session);
  if (found == troubles_.end() || found->second.deaths + found->second.kills == 0 || is_aside(session)) return;
  found->second.deaths = found->second.kills = 0;
  (void)write_durably(PutTrouble{found->second});
}

/// Takes the session out of the pipeline and the atlas. Its stored data stays, except for what `write` changes.
Result<void> MergeWorker::leave_out(SessionId session, PutMerge write) {
  const AttemptReport report = pipeline_->set_aside(session);
  schedule_.robot_left(session);  // no cloud of it is waited for any longer
  Known& known = known_[session];
  Known left;
  left.answers = known.answers;
  left.asks_where = known.asks_where;
  known = std::move(left);
  take_question_aside(session, known.asks_where);
  if (troubles_[session].deleted) known_.erase(session);
  draft_.sessions[session].distance_m = 0;
  if (!commit(std::move(write), report, nullptr)) return failure(ErrorCode::unavailable, stop_reason_);
  update_view();
  return {};
}

Result<void> MergeWorker::put_aside(SessionId session, const std::string& why, bool deleted) {
  if (!known_.contains(session)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(session));
  TroubleRecord trouble = troubles_.contains(session) ? troubles_[session] : TroubleRecord{session, 0, 0, {}, false};
  trouble.why_aside = why;
  trouble.deleted = deleted;
  troubles_[session] = trouble;
  if (deleted) archived_.erase(session), frozen_.erase(session);
  PutMerge write;
  write.trouble = PutTrouble{trouble};
  if (auto left = leave_out(session, std::move(write)); !left) return left;
  spdlog::warn("session {} is {}: {}", session, deleted ? "deleted" : "set aside", why);
  return {};
}

Result<void> MergeWorker::take_back(SessionId session) {
  if (!known_.contains(session)) return failure(ErrorCode::not_found, "there is no session " + std::to_string(session));
  const auto trouble = troubles_.find(session);
  if (trouble == troubles_.end() || trouble->second.why_aside.empty())
    return failure(ErrorCode::refused, "the session is not set aside");
  PutMerge write;
  write.trouble = PutTrouble{{session, 0, 0, {}, false}};
  troubles_.erase(trouble);
  if (archived_.contains(session))
    return write_durably(write) ? Result<void>() : failure(ErrorCode::unavailable, stop_reason_);
  if (auto back = bring_in_again(session, std::move(write)); !back) return back;
  spdlog::info("session {} is merged again", session);
  return {};
}

void MergeWorker::set_aside(SessionId session, const std::string& why, std::function<void(const Result<void>&)> done) {
  give([this, session, why, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? put_aside(session, why, false) : admitted);
  });
}

void MergeWorker::release(SessionId session, std::function<void(const Result<void>&)> done) {
  give([this, session, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? take_back(session) : admitted);
  });
}

void MergeWorker::remove(SessionId session, std::function<void(const Result<void>&)> done) {
  give([this, session, done = std::move(done)](const Result<void>& admitted) {
    done(admitted ? put_aside(session, "deleted by the operator", true) : admitted);
  });
}

}  // namespace headframe
