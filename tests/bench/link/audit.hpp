#pragma once
// Compares what a base station has on disk with what its robots produced and what they were told is durable.

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "tests/support/process.hpp"

namespace headframe::bench {

/// All that a robot which was never disturbed would deliver: the oracle. Bytes as they are stored.
struct Produced {
  std::vector<std::string> keyframes;  // [i]: sequence i + 1, as its wire message
  std::vector<std::string> clouds;     // encoded; empty: none
};

/// Drives `robot` for so many keyframes into a spool in `scratch`, without a server, and reads that spool.
Result<Produced> produce(const std::string& robot, std::uint64_t keyframes, const std::filesystem::path& scratch);

/// What a robot was told. Read from its spool, or from a copy of it.
struct Told {
  std::uint64_t keyframes = 0;     // acknowledged: all up to here
  std::uint64_t produced = 0;      // in the spool
  std::set<std::uint64_t> clouds;  // acknowledged
};
Result<Told> told(const std::string& robot, const std::filesystem::path& spool);
/// The same of a robot that runs, and is halted for the moment; its spool is copied to `copy`, which is replaced.
Result<Told> told_so_far(const std::string& robot, const std::filesystem::path& spool, const test::Process& process,
                         const std::filesystem::path& copy);

struct Faults {
  std::uint64_t lost = 0;        // acknowledged and not stored
  std::uint64_t duplicated = 0;  // stored twice: another session of the robot, or the content of another number
  std::uint64_t corrupted = 0;   // stored and not what was produced; holes
  std::uint64_t clouds_corrupted = 0;
  std::uint64_t clouds_lost = 0;
  std::uint64_t keyframes = 0, clouds = 0;  // stored
  std::string first;                        // in words
  std::uint64_t sum() const { return lost + duplicated + corrupted + clouds_corrupted + clouds_lost; }
  void add(const Faults& other);
};

/// Reads the database of a server that may be running: SQLite's below `data`, or that of a postgresql:// URL if it is
/// not empty. unavailable: it can not be read.
Result<Faults> audit(const std::filesystem::path& data, const std::map<std::string, Produced>& produced,
                     const std::map<std::string, Told>& told, const std::string& url = "");

}  // namespace headframe::bench
