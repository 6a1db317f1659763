// The pipeline's source of clouds: the store, or the robots.

#include "common/cloud/cloud_codec.hpp"
#include "server/merge_worker/merge_worker.hpp"

namespace headframe {

CloudState MergeWorker::state(const KeyframeRef& keyframe) const {
  const auto it = known_.find(keyframe.session);
  if (it == known_.end()) return CloudState::unobtainable;
  const Known& known = it->second;
  if (known.stored.contains(keyframe.sequence)) return CloudState::stored;
  if (known.let_go.contains(keyframe.sequence)) return CloudState::let_go;
  const bool can_come =
      known.answers && !known.without_cloud.contains(keyframe.sequence) && !schedule_.in_vain(keyframe);
  return can_come ? CloudState::obtainable : CloudState::unobtainable;
}

Result<CloudDecoder> MergeWorker::load(const KeyframeRef& keyframe) {
  auto encoded = read_patiently([&] { return store_.cloud(keyframe); });
  if (!encoded) return tl::unexpected(encoded.error());
  return [bytes = std::move(*encoded)] { return decode_points(bytes); };
}

Result<std::size_t> MergeWorker::ask_for_clouds(SessionId session) {
  const auto it = known_.find(session);
  if (it == known_.end()) return failure(ErrorCode::not_found, "there is no session " + std::to_string(session));
  const Known& known = it->second;
  if (!known.answers)
    return failure(ErrorCode::refused, "the session's robot is away, or was told never to send clouds");
  std::vector<std::uint64_t> missing;
  for (std::uint64_t sequence = 1; sequence <= known.keyframes; ++sequence)
    if (!known.stored.contains(sequence) && !known.without_cloud.contains(sequence) && !known.let_go.contains(sequence))
      missing.push_back(sequence);
  if (!missing.empty()) robots_->request_submap(session, missing);
  return missing.size();
}

void MergeWorker::request(const std::vector<KeyframeRef>& clouds) {
  std::map<SessionId, std::vector<std::uint64_t>> of_robot;
  for (const KeyframeRef& cloud : clouds) of_robot[cloud.session].push_back(cloud.sequence);
  for (const auto& [session, sequences] : of_robot) robots_->request_submap(session, sequences);
}

}  // namespace headframe
