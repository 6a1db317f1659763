#pragma once
// Named operators: what each may do, and until when.

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

/// Each role includes those before it. view: looks and exports; operate: decides on merges, names, surveys and notes;
/// administer: decides which robots and operators have access, and deletes sessions.
enum class Role { view, operate, administer };

std::string_view to_string(Role role);
/// "view", "operate", "administer".
std::optional<Role> role_from(std::string_view text);

struct OperatorIdentity {
  std::string name;  // empty: the server's own token, or no token is required
  Role role = Role::administer;
  double expires_s = 0;  // since the epoch; 0: never
};

/// Named operators in DATA/operators.json (mode 0600). Tokens are 32 random bytes, of which only digests are stored.
/// add() and revoke() block until their change is on the disk. Times are seconds since the epoch. Thread safe.
class OperatorRegistry {
 public:
  static constexpr std::size_t most_operators = 100;
  static constexpr double most_lifetime_s = 3650.0 * 86400;

  /// Fails like read_private_file, except not_found; bad_input: the file is damaged.
  static Result<std::unique_ptr<OperatorRegistry>> open(const std::filesystem::path& file);

  /// Returns the token, 64 hexadecimal digits, which is not stored. For an existing operator it replaces role and
  /// token. invalid_argument: an invalid name or lifetime; refused: there are too many operators.
  Result<std::string> add(const std::string& name, Role role, double lifetime_s, double now_s);
  /// not_found: no such operator.
  Result<void> revoke(const std::string& name);
  std::vector<OperatorIdentity> operators() const;  // by name
  /// The operator with this token, even if it has expired.
  std::optional<OperatorIdentity> find(std::string_view token) const;
  /// Whether this operator still has the same role and expiry and has not expired.
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
