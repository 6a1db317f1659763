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

Scene SessionSubmaps::scene(SessionId id, std::vector<KeyframePosition> positions, CloudSource& clouds) {
  return {std::move(positions), [this, id, &clouds](std::span<const std::size_t> keyframes) {
            std::vector<SubmapRequest> asked;
            asked.reserve(keyframes.size());
            for (const std::size_t k : keyframes) asked.push_back(at(id, k));
            return near(asked, clouds);
          }};
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
