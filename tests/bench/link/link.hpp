#pragma once
// ./run bench link: what the link costs and what it stands.

#include <filesystem>
#include <nlohmann/json.hpp>

namespace headframe::bench {

/// argv[0] is "link". Figures are printed and join those in `out`/link.json. Exit status: 1 when something was lost,
/// duplicated or corrupted, or a program failed.
int link_main(int argc, char** argv, const std::filesystem::path& out);

nlohmann::json link_bytes();

}  // namespace headframe::bench
