#pragma once
// ./run bench descriptors: which descriptor for which mine? Families side by side.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace headframe::bench {

struct DescriptorBench {
  std::vector<std::string> families;  // as make_family takes them
  std::filesystem::path recordings;   // data sets; rows of those that are absent are left out
  std::filesystem::path pictures;     // folder
  int mines = 6;                      // of each kind
};

/// Minutes. The figures by family name (`scan_context.recall1.same`, ...). Fails on an unknown family (not_found), a
/// mine that cannot be driven, or pictures that cannot be written.
Result<nlohmann::json> descriptors(const DescriptorBench& bench);

}  // namespace headframe::bench
