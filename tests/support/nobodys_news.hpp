#pragma once
// A merge worker that does not listen.

#include "server/merge_worker/merge_news.hpp"

namespace headframe {

class NobodysNews : public MergeNews {
 public:
  void session_added(SessionId, const NewSession&) override {}
  void keyframes_durable(SessionId, std::uint64_t) override {}
  void poses_durable(SessionId) override {}
  void cloud_durable(const KeyframeRef&) override {}
  void clouds_unavailable(SessionId, const std::vector<std::uint64_t>&) override {}
  void robot_came(SessionId, bool) override {}
  void robot_left(SessionId) override {}
  void trigger(SessionId, Trigger) override {}
  void asks_where(SessionId, bool) override {}
};

}  // namespace headframe
