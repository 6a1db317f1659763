#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/endpoint.hpp"
#include "common/result.hpp"
#include "server/merge/merge_config.hpp"
#include "server/merge_worker/schedule_config.hpp"
#include "server/net/robot_limits.hpp"

namespace headframe {

/// How the operator's API and page are served. beyond_loopback: HTTPS, and plain HTTP on the loopback, unless a
/// certificate is given; always: HTTPS; never: plain HTTP, also where others can listen.
enum class OperatorTls { beyond_loopback, always, never };

/// What becomes of clouds when room is short. all: they stay; newest: the oldest go, of rock that later sessions keep.
enum class KeepClouds { all, newest };

/// [operator]
struct OperatorConfig {
  OperatorTls tls = OperatorTls::beyond_loopback;
  std::string
      certificate;  // PEM file, with those of its issuers after it; empty: the one that robots know the server by
  std::string key;  // PEM file of its private key; empty: it is in `certificate`
};

/// Everything a configuration file may set, with the defaults of a server without one.
struct ServerConfig {
  int io_threads = 2;                      // [server]
  std::string name;                        // [server], for the other servers; empty: the host and its data directory
  std::optional<Endpoint> public_address;  // [server] public: where robots reach this server; none: where it listens
  std::string store_url;                   // [store] url: postgresql://...; empty: SQLite in the data directory
  bool standby = false;                    // [store]: a database that another server uses is waited for
  bool helps = true;                       // [store]: while it stands by, it searches pairs for the active server
  KeepClouds keep = KeepClouds::all;       // [store], and the next two
  int free_mib = 1024;                     // that are to stay free while keep = "newest"
  int clouds_mib = 0;                      // that clouds may take in PostgreSQL, whose disk nobody knows; 0: no limit
  int database_mib = 0;                    // [limits]: of SQLite's file, reached like a full disk; 0: none
  int write_queue_mib = 256;               // [limits]: of all robots together
  OperatorConfig operators;
  RobotLimits limits;
  ScheduleConfig schedule;
  MergeConfig merge;
};

/// TOML. bad_input names file, line and key when a key is unknown (with the keys there are), of another type, or out of
/// range; and when the file is no TOML. `name` stands for the file in messages.
Result<ServerConfig> parse_config(std::string_view text, const std::string& name);

/// not_found when there is no such file.
Result<ServerConfig> load_config(const std::filesystem::path& path);

}  // namespace headframe
