#pragma once
// The store on an SQL database, through the connections it is given.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <set>

#include "server/store/data_directory.hpp"
#include "server/store/store_writer.hpp"

namespace headframe {

/// The parts of a store.
struct SqlStoreParts {
  DataDirectory directory;
  std::unique_ptr<Database> reader;
  std::unique_ptr<WriterConnection> writer;
  StoreOptions options;
  /// Writes a backup to this file.
  std::function<Result<void>(const std::filesystem::path& file)> write_backup;
  /// Like Store::free_bytes(), using the reader.
  std::function<Result<std::optional<std::uint64_t>>(Database& reader)> free_bytes;
};

class SqlStore final : public Store {
 public:
  explicit SqlStore(SqlStoreParts parts);

  void write(Write write, Done done) override { writer_.write(std::move(write), std::move(done)); }
  StoreLoad load() const override;
  bool is_away() override;
  Result<std::vector<SessionRecord>> sessions() override;
  Result<void> each_keyframe(SessionId session, std::uint64_t first,
                             const std::function<void(Keyframe)>& visit) override;
  Result<NewPoses> new_poses(SessionId session) override;
  Result<std::uint64_t> last_keyframe(SessionId session) override;
  Result<std::vector<std::uint64_t>> cloud_sequences(SessionId session) override;
  Result<std::vector<CloudSize>> cloud_sizes(SessionId session) override;
  Result<std::vector<std::uint64_t>> let_go(SessionId session) override;
  Result<std::optional<std::uint64_t>> free_bytes() override;
  Result<std::string> cloud(const KeyframeRef& keyframe) override;
  Result<StoredMerge> merge() override;
  Result<StoredNotes> notes() override;
  Result<std::vector<RobotRecord>> robots() override;
  Result<std::map<std::string, std::string>> robot_sites() override;
  Result<std::vector<TroubleRecord>> troubles() override;
  Result<std::filesystem::path> backup() override;

 private:
  void note_damage(const KeyframeRef& keyframe);

  DataDirectory directory_;
  std::function<Result<void>(const std::filesystem::path&)> write_backup_;
  std::function<Result<std::optional<std::uint64_t>>(Database&)> free_bytes_;
  std::mutex mutex_;  // protects reader_ and damaged_
  std::set<KeyframeRef> damaged_;
  std::atomic<std::size_t> damaged_count_ = 0;
  std::mutex backup_mutex_;
  int backups_ = 0;
  std::unique_ptr<Database> reader_;
  StoreWriter writer_;
};

}  // namespace headframe
