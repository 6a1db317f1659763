#pragma once
// Operators by name: what each may do, and for how long.

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe {

/// Each may do what those before it may. view: looks and exports; operate: decides on merges, names, surveys and
/// notes; administer: says which robots and operators come in, and deletes sessions.
enum class Role { view, operate, administer };

std::string_view to_string(Role role);
/// "view", "operate", "administer".
std::optional<Role> role_from(std::string_view text);

struct OperatorIdentity {
  std::string name;  // empty: who shows the server's own token, or anybody where none is asked for
  Role role = Role::administer;
  double expires_s = 0;  // since the epoch; 0: never
};

/// Named operators in DATA/operators.json (mode 0600). Tokens are 32 random bytes; only their digests are kept. What
/// add() and revoke() return well is on the disk; they wait for it. Times are seconds since the epoch. Thread safe.
class OperatorRegistry {
 public:
  static constexpr std::size_t most_operators = 100;
  static constexpr double most_lifetime_s = 3650.0 * 86400;

  /// Errors are those of read_private_file, but not_found; bad_input: the file is damaged.
  static Result<std::unique_ptr<OperatorRegistry>> open(const std::filesystem::path& file);

  /// The token, 64 hexadecimal digits, which is told this once. An operator who is known gets another role and token,
  /// and the old one ends. invalid_argument: no name, or no lifetime; refused: there are too many.
  Result<std::string> add(const std::string& name, Role role, double lifetime_s, double now_s);
  /// not_found: there is no such operator.
  Result<void> revoke(const std::string& name);
  std::vector<OperatorIdentity> operators() const;  // by name
  /// Whose token this is, also one that has expired.
  std::optional<OperatorIdentity> find(std::string_view token) const;
  /// Whether this one still has the role, and until then.
  bool stands(const OperatorIdentity& who, double now_s) const;

 private:
  struct Entry {
    OperatorIdentity who;
    std::string digest;  // of the token
  };
  explicit OperatorRegistry(std::filesystem::path file) : file_(std::move(file)) {}
  Result<void> read();
  Result<void> write(const std::map<std::string, Entry>& entries) const;

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace headframe
