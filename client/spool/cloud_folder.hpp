#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace headframe {

/// The encoded clouds in a spool: one file each, named by the keyframe's sequence in ten digits. Not thread safe. Uses
/// about 50 bytes of memory for each cloud.
class CloudFolder {
 public:
  /// sync: a cloud is on the disk (fdatasync) when write() returns.
  CloudFolder(std::filesystem::path directory, bool sync) : directory_(std::move(directory)), sync_(sync) {}

  /// Reads the directory, which has to exist. Clouds of keyframes beyond `last` are removed, and so are those in
  /// `settled`, whose removal was interrupted. unavailable: the disk failed.
  Result<void> find(std::uint64_t last, const std::set<std::uint64_t>& settled);

  /// Replaces an earlier cloud of this sequence. unavailable: the disk failed; then there is none of this sequence.
  Result<void> write(std::uint64_t sequence, std::string_view bytes);
  /// not_found: there is none; otherwise like RecordLog::read().
  Result<std::string> read(std::uint64_t sequence) const;
  /// Does nothing if there is none.
  void remove(std::uint64_t sequence);

  bool holds(std::uint64_t sequence) const { return bytes_of_.contains(sequence); }
  std::uint64_t next(std::uint64_t from) const;  // the first held cloud at or after `from`; 0: none
  std::uint64_t count() const { return bytes_of_.size(); }
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::filesystem::path path_of(std::uint64_t sequence) const;
  void note(std::uint64_t sequence, std::uint64_t bytes);

  std::filesystem::path directory_;
  bool sync_;
  std::map<std::uint64_t, std::uint64_t> bytes_of_;  // of each file
  std::uint64_t bytes_ = 0;                          // of all
};

}  // namespace headframe
