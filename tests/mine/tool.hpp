#pragma once
// What the mine's tools share: a fault that is thrown ends in one line and status 1.

#include <cstdio>
#include <exception>

namespace headframe::mine {

inline int run_tool(const char* name, int (*run)(int, char**), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace headframe::mine
