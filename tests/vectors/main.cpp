// headframe-make-vectors DIR: writes the protocol's test vectors anew. To be run when the protocol has changed, and its
// difference to be read: what changes here changes for every robot.

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/vectors/vectors.hpp"

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "usage: headframe-make-vectors DIR (proto/headframe/v1/vectors)\n");
    return 2;
  }
  for (const auto& file : headframe::vectors::all_files()) {
    const auto path = std::filesystem::path(argv[1]) / (file.name + ".json");
    if (std::ofstream(path, std::ios::binary) << headframe::vectors::to_text(file.content)) continue;
    std::fprintf(stderr, "headframe-make-vectors: %s can not be written\n", path.c_str());
    return 1;
  }
  return 0;
}
