// The parts of a network that need no runtime.
#include <fstream>
#include <iterator>

#include "common/descriptor/network.hpp"

namespace headframe {

Result<std::string> Network::read(const std::filesystem::path& file) {
  std::error_code ignored;
  std::ifstream in(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file, ignored) || !in)
    return failure(ErrorCode::not_found, file.string() + ": no file that can be read");
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) return failure(ErrorCode::not_found, file.string() + ": can not be read to its end");
  return bytes;
}

std::string to_string(const Network::Shape& s) {
  return std::to_string(s.channels) + "x" + std::to_string(s.rows) + "x" + std::to_string(s.columns);
}

}  // namespace headframe
