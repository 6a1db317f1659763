#include "server/cli/token.hpp"

#include <cstdlib>

#include "common/security/private_file.hpp"

namespace headframe {

Result<std::string> find_token(const std::string& file) {
  const char* given = std::getenv("HEADFRAME_TOKEN");
  if (file.empty() && given != nullptr) return std::string(given);
  auto token = read_private_file(file.empty() ? "headframe-data/operator.token" : file);
  if (!token && token.error().code == ErrorCode::not_found && file.empty()) return std::string();
  if (!token) return tl::unexpected(token.error());
  while (!token->empty() && token->back() == '\n') token->pop_back();
  return token;
}

}  // namespace headframe
