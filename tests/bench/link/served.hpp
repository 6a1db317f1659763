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
};

/// On free ports, with its data, configuration and log in `scratch`; on the data of an earlier one where there are any.
Result<Served> serve(const std::filesystem::path& scratch, const std::string& config);

}  // namespace headframe::bench
