#include "client/spool/spool.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <random>
#include <set>
#include <utility>

#include "common/wire/limits.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;
enum RecordType : char {
  identity_record = 'i',
  keyframe_record = 'k',
  keyframe_ack = 'a',
  cloud_ack = 'c',
  cloud_drop = 'd',
  pose_update = 'u',
  pose_ack = 'v',
  run_record = 'r',
  run_welcome = 'w'
};

std::uint64_t random_u64() {
  std::random_device device;
  return (std::uint64_t{device()} << 32 | device()) | 1;  // never 0
}

std::string random_name() {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(random_u64()));
  return text;
}

std::string text_of(const FamilySpec& family) {
  return family.id.name + " version " + std::to_string(family.id.version) + " (" + std::to_string(family.q_size) +
         " + " + std::to_string(family.w_size) + " values)";
}

std::uint64_t to_u64(std::string_view digits) {
  std::uint64_t v = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), v);
  return v;
}

tl::unexpected<Error> refused(const fs::path& directory, const std::string& what) {
  return failure(ErrorCode::refused, directory.string() + ": " + what);
}

}  // namespace

Result<FileDescriptor> Spool::lock(const fs::path& directory) {
  const std::string path = (directory / "lock").string();
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (file.get() < 0) return failure(ErrorCode::unavailable, path + ": can not be written");
  if (::flock(file.get(), LOCK_EX | LOCK_NB) == 0) return file;
  return refused(directory, "another process uses this spool; give every robot a directory of its own");
}

Result<Spool> Spool::open(const SpoolConfig& config, Hello robot) {
  std::error_code fault;
  fs::create_directories(config.directory / "clouds", fault);
  if (fault) return failure(ErrorCode::unavailable, config.directory.string() + ": " + fault.message());
  auto lock_file = lock(config.directory);
  if (!lock_file) return tl::unexpected(lock_file.error());

  std::vector<std::uint64_t> keyframe_at;
  std::uint64_t keyframes = 0, welcomed = 0;
  PoseLog poses;
  std::vector<std::uint64_t> runs;
  std::set<std::uint64_t> acknowledged, dropped;
  std::string identity;
  auto log = RecordLog::open(config.directory / "session.log", [&](const Record& r) {
    if (r.type == identity_record) identity = r.payload;
    if (r.type == keyframe_record) keyframe_at.push_back(r.at_byte);
    if (r.type == keyframe_ack) keyframes = std::max(keyframes, to_u64(r.payload));
    if (r.type == cloud_ack) acknowledged.insert(to_u64(r.payload));
    if (r.type == cloud_drop) dropped.insert(to_u64(r.payload));
    if (r.type == pose_update) poses.found(r.at_byte, keyframe_at.size());
    if (r.type == pose_ack) poses.acknowledged(to_u64(r.payload));
    if (r.type == run_record) runs.push_back(to_u64(r.payload));
    if (r.type == run_welcome) welcomed = to_u64(r.payload);
  });
  if (!log) return tl::unexpected(log.error());
  Spool spool(config, std::move(*lock_file), std::move(*log));
  spool.keyframe_at_ = std::move(keyframe_at);
  spool.poses_ = std::move(poses);
  spool.acknowledged_keyframes_ = std::min<std::uint64_t>(keyframes, spool.last_sequence());
  spool.acknowledged_clouds_ = acknowledged.size();
  spool.dropped_clouds_ = dropped.size();
  if (spool.log_.cut_bytes() > 0)
    spool.warnings_.push_back("session.log: an unfinished record of " + std::to_string(spool.log_.cut_bytes()) +
                              " bytes at its end was cut off");
  v1::Hello message;
  if (!identity.empty()) {
    if (!message.ParseFromString(identity)) return failure(ErrorCode::bad_input, "session.log: identity is unreadable");
    auto hello = from_proto(message);
    if (!hello) return tl::unexpected(hello.error());
    spool.identity_ = std::move(*hello);
    spool.resumed_ = true;
  }
  if (auto ok = spool.settle_identity(std::move(robot)); !ok) return tl::unexpected(ok.error());
  if (auto ok = spool.begin_run(runs, welcomed); !ok) return tl::unexpected(ok.error());
  acknowledged.merge(dropped);
  if (auto ok = spool.clouds_.find(spool.last_sequence(), acknowledged); !ok) return tl::unexpected(ok.error());
  spool.keep_quota();
  return spool;
}

Result<void> Spool::settle_identity(Hello robot) {
  if (resumed_) {
    const auto& mine = identity_;
    if (mine.session.robot != robot.session.robot)
      return refused(config_.directory, "this spool belongs to robot " + mine.session.robot);
    if (!robot.session.session.empty() && mine.session.session != robot.session.session)
      return refused(config_.directory, "this spool holds session " + mine.session.session);
    if (mine.family.id != robot.family.id || mine.family.q_size != robot.family.q_size ||
        mine.family.w_size != robot.family.w_size)
      return refused(config_.directory, "this spool holds descriptors of family " + text_of(mine.family) + ", not " +
                                            text_of(robot.family) +
                                            "; go on with that one, or give another family a spool of its own");
    identity_.clouds = robot.clouds;
    identity_.software = robot.software;
    identity_.capabilities = robot.capabilities;
    return {};
  }
  if (robot.session.session.empty()) robot.session.session = random_name();
  if (robot.spool_id == 0) robot.spool_id = random_u64();
  const auto message = to_proto(robot);
  if (auto ok = from_proto(message); !ok) return failure(ErrorCode::invalid_argument, ok.error().message);
  identity_ = std::move(robot);
  if (auto at = log_.append(identity_record, message.SerializeAsString(), config_.sync); !at)
    return tl::unexpected(at.error());
  if (config_.sync &&
      !(sync_directory(config_.directory) && sync_directory(fs::absolute(config_.directory).parent_path())))
    return failure(ErrorCode::unavailable, config_.directory.string() + ": can not be synced");
  return {};
}

/// The server knows one of these runs: the last one that it accepted, or a later one whose welcome was lost.
Result<void> Spool::begin_run(const std::vector<std::uint64_t>& runs, std::uint64_t welcomed) {
  constexpr std::size_t others = limits::spool_runs - 1;
  auto& mine = identity_.spool_runs;
  mine.assign(runs.end() - static_cast<std::ptrdiff_t>(std::min(runs.size(), others)), runs.end());
  if (welcomed != 0 && std::find(mine.begin(), mine.end(), welcomed) == mine.end()) {
    if (mine.size() == others) mine.erase(mine.begin());
    mine.insert(mine.begin(), welcomed);
  }
  mine.push_back(random_u64());
  // On the disk before any server hears of it: otherwise a power cut would make this spool look like a copy.
  if (auto at = log_.append(run_record, std::to_string(mine.back()), config_.sync); !at)
    return tl::unexpected(at.error());
  return {};
}

Result<void> Spool::run_welcomed() {
  if (auto at = log_.append(run_welcome, std::to_string(identity_.spool_runs.back()), false); !at)
    return tl::unexpected(at.error());
  return {};
}

Result<void> Spool::append(const Keyframe& keyframe, std::string_view encoded_cloud) {
  if (keyframe.sequence != last_sequence() + 1)
    return failure(ErrorCode::internal,
                   "keyframe " + std::to_string(keyframe.sequence) + " after " + std::to_string(last_sequence()));
  const auto message = to_proto(keyframe);
  if (!message) return tl::unexpected(message.error());
  if (auto ok = from_proto(*message); !ok) return failure(ErrorCode::invalid_argument, ok.error().message);
  if (!encoded_cloud.empty()) keep_cloud(keyframe.sequence, encoded_cloud);
  const std::string record = message->SerializeAsString();
  auto at = log_.append(keyframe_record, record, config_.sync);
  if (!at && make_room(record.size())) at = log_.append(keyframe_record, record, config_.sync);
  if (!at) {
    clouds_.remove(keyframe.sequence);
    return tl::unexpected(at.error());
  }
  keyframe_at_.push_back(*at);
  keep_quota();
  return {};
}

Result<void> Spool::update_poses(std::vector<KeyframePose> poses) {
  const auto record = poses_.record_of(std::move(poses), last_sequence());
  if (!record) return tl::unexpected(record.error());
  auto at = log_.append(pose_update, *record, config_.sync);
  if (!at && make_room(record->size())) at = log_.append(pose_update, *record, config_.sync);
  if (!at) return tl::unexpected(at.error());
  poses_.found(*at, last_sequence());
  return {};
}

/// If the disk has no room for the cloud even without older ones, the keyframe is kept without it.
void Spool::keep_cloud(std::uint64_t sequence, std::string_view bytes) {
  auto written = clouds_.write(sequence, bytes);
  if (!written && make_room(bytes.size())) written = clouds_.write(sequence, bytes);
  if (!written) note_dropped(sequence);
}

/// Drops the oldest clouds, twice as many bytes as requested; false if there was none.
bool Spool::make_room(std::uint64_t bytes) {
  const auto before = clouds_.bytes();
  if (clouds_.count() == 0) return false;
  while (clouds_.count() > 0 && before - clouds_.bytes() < 2 * bytes) drop_cloud(clouds_.next(1));
  return true;
}

Result<Keyframe> Spool::keyframe(std::uint64_t sequence) const {
  if (sequence < 1 || sequence > last_sequence())
    return failure(ErrorCode::not_found, "no keyframe " + std::to_string(sequence) + " in the spool");
  const auto bytes = log_.read(keyframe_at_[sequence - 1]);
  if (!bytes) return tl::unexpected(bytes.error());
  v1::Keyframe message;
  if (!message.ParseFromString(*bytes)) return failure(ErrorCode::bad_input, "session.log: a keyframe is unreadable");
  return from_proto(message);
}

Result<void> Spool::acknowledge_keyframes(std::uint64_t up_to) {
  up_to = std::min(up_to, last_sequence());
  if (up_to <= acknowledged_keyframes_) return {};
  acknowledged_keyframes_ = up_to;
  if (auto at = log_.append(keyframe_ack, std::to_string(up_to), false); !at) return tl::unexpected(at.error());
  return {};
}

Result<void> Spool::acknowledge_poses(std::uint64_t up_to) {
  if (up_to <= poses_.acknowledged()) return {};
  poses_.acknowledged(up_to);
  if (auto at = log_.append(pose_ack, std::to_string(up_to), false); !at) return tl::unexpected(at.error());
  return {};
}

Result<void> Spool::acknowledge_cloud(std::uint64_t sequence) {
  if (!holds_cloud(sequence)) return {};
  const auto at = log_.append(cloud_ack, std::to_string(sequence), false);
  clouds_.remove(sequence);
  ++acknowledged_clouds_;
  if (!at) return tl::unexpected(at.error());
  return {};
}

void Spool::drop_cloud(std::uint64_t sequence) {
  if (!holds_cloud(sequence)) return;
  note_dropped(sequence);
  clouds_.remove(sequence);
}

/// For statistics only: if this record is lost, one drop is missing from them.
void Spool::note_dropped(std::uint64_t sequence) {
  [[maybe_unused]] const auto at = log_.append(cloud_drop, std::to_string(sequence), false);
  ++dropped_clouds_;
}

void Spool::keep_quota() {
  while (clouds_.bytes() > config_.cloud_quota_bytes) drop_cloud(clouds_.next(1));
}

}  // namespace headframe
