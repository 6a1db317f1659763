#pragma once
// The robot in plain Python (client/python), as a user would start it.

#include <string>
#include <vector>

namespace headframe::test {

/// argv up to the client's own options. script: a file of tests/python; empty: the client itself.
inline std::vector<std::string> python_robot(const std::string& script = "") {
  const std::string path = std::string("PYTHONPATH=") + HEADFRAME_PYTHONPATH;
  std::vector<std::string> argv{"/usr/bin/env", path, "PYTHONDONTWRITEBYTECODE=1", "OPENBLAS_NUM_THREADS=1",
                                HEADFRAME_PYTHON};
  if (script.empty())
    argv.insert(argv.end(), {"-m", "headframe_plain"});
  else
    argv.push_back(HEADFRAME_SOURCE_DIR "/tests/python/" + script);
  return argv;
}

}  // namespace headframe::test
