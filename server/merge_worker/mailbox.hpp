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
  bool poses = false;  // of keyframes that were added earlier
  std::set<std::uint64_t> clouds_came, clouds_gone, clouds_let_go;
  bool ended = false, asks = false;  // its robot ended the session; asked for a merge
  bool left = false;                 // applied before `came`
  std::optional<bool> asks_where;    // its robot starts or stops asking where it is
  std::optional<bool> came;          // its robot connected; whether it answers submap requests
  std::optional<std::pair<Trigger, MergeSchedule::Time>> trigger;  // the first trigger
};

/// News by session. Bounded by what the sessions hold, however long the worker is busy.
using Mailbox = std::map<SessionId, SessionNews>;

}  // namespace headframe
