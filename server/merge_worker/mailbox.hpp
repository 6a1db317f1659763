#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>

#include "server/merge_worker/merge_news.hpp"

namespace headframe {

/// What has happened to one session since the worker last looked.
struct SessionNews {
  std::optional<NewSession> added;
  std::uint64_t durable_keyframes = 0;
  bool poses = false;  // of keyframes that came before its last ones
  std::set<std::uint64_t> clouds_came, clouds_gone, clouds_let_go;
  bool ended = false, asks = false;                                // its robot said goodbye, asked for a merge
  bool left = false;                                               // comes before `came`
  std::optional<bool> asks_where;                                  // whether its robot asks where it is
  std::optional<bool> came;                                        // whether it answers
  std::optional<std::pair<Trigger, MergeSchedule::Time>> trigger;  // the first
};

/// News by session: bounded by what the sessions hold, however long the worker is busy.
using Mailbox = std::map<SessionId, SessionNews>;

}  // namespace headframe
