// Robots that ask where they are: what they are told, and when.

#include <spdlog/spdlog.h>

#include "server/merge_worker/merge_worker.hpp"

namespace headframe {

void MergeWorker::take_question(SessionId session, bool asks) {
  Known& known = known_[session];
  known.told_where.reset();
  if (known.asks_where == asks && !asks) return;
  known.asks_where = asks;
  (void)pipeline_->ask_where(session, asks);
  schedule_.asks_where(session, asks, Clock::now());
  if (!asks) schedule_.grows(session, Clock::now());  // from now on it may pause; while its robot asked, it could not
}

/// For a session that is set aside; it asks again when it is released.
void MergeWorker::take_question_aside(SessionId session, bool asks) {
  const auto known = known_.find(session);
  if (known == known_.end()) return;
  known->second.asks_where = asks;
  known->second.told_where.reset();
  if (asks && robots_)
    robots_->tell_localization(session, {.missing = "the session is set aside; the operator's page says why"});
}

/// Tells a robot that asks if its answer has changed, but not in the middle of an attempt, which may next find a rival.
/// all: tells all that ask; else only those that have had no answer.
void MergeWorker::tell_where(bool all) {
  for (auto& [session, known] : known_) {
    if (!known.asks_where || is_aside(session) || (known.told_where && (!all || known.more_to_try))) continue;
    const SessionLocalization now = pipeline_->localization(session);
    if (known.told_where == now) continue;
    const bool was_found = known.told_where && known.told_where->found;
    if (now.found && !was_found)
      spdlog::info("session {} is localized on session {} at keyframe {}, probability {:.3f}", session, now.on,
                   now.keyframe, now.probability);
    if (!now.found && was_found) spdlog::error("the localization of session {} is withdrawn: {}", session, now.missing);
    known.told_where = now;
    robots_->tell_localization(session, now);
  }
}

}  // namespace headframe
