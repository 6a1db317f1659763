#include "server/merge/session_submaps.hpp"

namespace headframe {
namespace {

constexpr std::size_t mb = 1000000;

std::size_t bytes(int megabytes) { return mb * static_cast<std::size_t>(megabytes); }

}  // namespace

SessionSubmaps::SessionSubmaps(const MergeConfig& config, const SessionMap& sessions)
    : sessions_(sessions),
      clouds_(bytes(config.clouds_mb), config.threads),
      near_(bytes(config.places_mb), config.threads, JudgeConfig{}.place, clouds_),
      far_(bytes(config.places_mb) / 8, config.threads, far_config(), clouds_) {}

SubmapConfig SessionSubmaps::far_config() {
  SubmapConfig config;
  config.radius_m = 1;  // little is needed for registration
  config.slack_m = 0;
  config.look_m = 25;
  config.look_leaf_m = 0.8F;
  config.view_reach_m = 35;
  return config;
}

SubmapRequest SessionSubmaps::at(SessionId id, std::size_t keyframe) const {
  const Session& session = sessions_.at(id);
  return {id, session.keyframes, session.path_to_m, keyframe};
}

std::vector<SubmapPair> SessionSubmaps::near(const OrderedPair& pair, std::span<const Meeting> meetings,
                                             CloudSource& clouds) {
  std::vector<SubmapRequest> asked;
  asked.reserve(2 * meetings.size());
  for (const Meeting& m : meetings) {
    asked.push_back(at(pair.a, m.keyframe_a));
    asked.push_back(at(pair.b, m.keyframe_b));
  }
  const std::vector<SubmapPtr> made = near(asked, clouds);
  std::vector<SubmapPair> out;
  out.reserve(meetings.size());
  for (std::size_t i = 0; i < meetings.size(); ++i) out.push_back({made[2 * i], made[2 * i + 1]});
  return out;
}

Scene SessionSubmaps::scene(const OrderedPair& pair, std::vector<KeyframePosition> a, std::vector<KeyframePosition> b,
                            CloudSource& clouds) {
  return {std::move(a), std::move(b),
          [this, pair, &clouds](std::span<const Meeting> meetings) { return near(pair, meetings, clouds); }};
}

bool SessionSubmaps::prepare_next(SessionId id, CloudSource& clouds) {
  const Session& session = sessions_.at(id);
  std::size_t& next = made_ahead_[id];
  if (next >= session.keyframes.size()) return false;
  const bool known = session.complete || session.path_to_m[next] + JudgeConfig{}.place.window_m < session.path_m();
  if (!known) return false;  // the robot still drives through what the submap will contain
  const SubmapRequest request = at(id, next++);
  near({&request, 1}, clouds);
  return true;
}

}  // namespace headframe
