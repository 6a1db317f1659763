#include "server/merge_worker/pair_replica.hpp"

#include "common/cloud/cloud_codec.hpp"
#include "server/store/session_reads.hpp"

namespace headframe {
namespace {

constexpr std::size_t digest_bytes = 32;  // of one session

}  // namespace

PairReplica::PairReplica(const MergeConfig& config, Database& database)
    : database_(database),
      sessions_(config),
      finder_(finder_config(config)),
      submaps_(config, sessions_),
      requests_(config, sessions_),
      self_(config, sessions_, finder_, submaps_, requests_),
      verifier_(config, sessions_, submaps_, self_, requests_),
      search_(config, sessions_, finder_, submaps_, requests_, self_, verifier_) {}

Result<std::string> PairReplica::find(const PairTask& task) {
  if (task.digest.size() != 2 * digest_bytes) return failure(ErrorCode::bad_input, "a pair's digest has another size");
  const std::string_view digest = task.digest;
  forget_others(task);
  auto done = bring(task.a, task.keyframes_a, task.complete_a, digest.substr(0, digest_bytes));
  if (done) done = bring(task.b, task.keyframes_b, task.complete_b, digest.substr(digest_bytes));
  if (!done) return tl::unexpected(done.error());
  return encode_findings(search_.find(task.a, task.b, *this));
}

/// Reads as little as is needed: nothing, the list of its clouds, or all of it.
Result<void> PairReplica::bring(SessionId id, std::uint64_t keyframes, bool complete, std::string_view digest) {
  if (known_.contains(id)) {
    if (known_[id].digest == digest) return {};
    if (auto done = look_for_clouds(id); !done) return done;
    if ((known_[id].digest = search_.digest(id, *this)) == digest) return {};
  }
  if (auto done = read_anew(id, keyframes, complete); !done) return done;
  if ((known_[id].digest = search_.digest(id, *this)) == digest) return {};
  forget(id);
  return failure(ErrorCode::refused, "session " + std::to_string(id) + " is not stored as the active server knows it");
}

Result<void> PairReplica::look_for_clouds(SessionId id) {
  const auto clouds = read_cloud_sequences(database_, id);
  if (!clouds) return tl::unexpected(clouds.error());
  known_[id].stored = {clouds->begin(), clouds->end()};
  return {};
}

Result<void> PairReplica::read_anew(SessionId id, std::uint64_t keyframes, bool complete) {
  forget(id);
  const auto family = read_family(database_, id);
  if (!family) return tl::unexpected(family.error());
  if (!*family) return failure(ErrorCode::refused, "session " + std::to_string(id) + " is not stored");
  sessions_.add(id, **family);
  auto read = read_keyframes(
      database_, id, 1,
      [&](Keyframe keyframe) {
        if (keyframe.sequence <= keyframes) sessions_.add_keyframe(id, std::move(keyframe));
      },
      [](std::uint64_t) {});
  if (read) read = look_for_clouds(id);
  if (!read) forget(id);
  if (read && complete) sessions_.complete(id);
  return read;
}

void PairReplica::forget(SessionId id) {
  known_.erase(id);
  submaps_.forget(id);
  finder_.forget(id);
  sessions_.forget(id);
}

void PairReplica::forget_others(const PairTask& task) {
  std::size_t count = 0;
  std::vector<SessionId> others;
  for (const auto& [id, session] : sessions_.all()) {
    count += session.keyframes.size();
    if (id != task.a && id != task.b) others.push_back(id);
  }
  if (count <= most_keyframes) return;
  for (const SessionId id : others) forget(id);
}

CloudState PairReplica::state(const KeyframeRef& keyframe) const {
  const auto known = known_.find(keyframe.session);
  const bool stored = known != known_.end() && known->second.stored.contains(keyframe.sequence);
  return stored ? CloudState::stored : CloudState::unobtainable;
}

Result<CloudDecoder> PairReplica::load(const KeyframeRef& keyframe) {
  auto encoded = read_cloud(database_, keyframe);
  if (!encoded) return tl::unexpected(encoded.error());
  return [bytes = std::move(*encoded)] { return decode_points(bytes); };
}

}  // namespace headframe
