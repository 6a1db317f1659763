#pragma once

#include <filesystem>
#include <string>

#include "tests/support/process.hpp"

namespace headframe::bench {

/// A headframe-server that runs as a process of its own, over TLS.
struct Served {
  test::Process process;
  std::uint16_t port = 0;  // for robots
  std::string http;        // HOST:PORT
  std::filesystem::path data;
  std::filesystem::path log;

  /// It serves, and does not wait for a database that another server has.
  bool is_active() const;
};

struct ServedAt {
  std::string listen = "127.0.0.1:0", http = "127.0.0.1:0";
};

/// With its data, configuration and log in `scratch`; on the data of an earlier one where there are any. It serves, or
/// stands by, when this returns.
Result<Served> serve(const std::filesystem::path& scratch, const std::string& config, const ServedAt& at = {});

/// Gives the server of `scratch` what robots and operators know `active` by, so that it can stand by for it.
Result<void> make_known_as(const Served& active, const std::filesystem::path& scratch);

}  // namespace headframe::bench
