#include "server/security/operator_registry.hpp"

#include <nlohmann/json.hpp>

#include "common/security/private_file.hpp"
#include "common/security/secret.hpp"
#include "common/wire/convert.hpp"

namespace headframe {
namespace {

constexpr std::size_t digest_bytes = 32;

tl::unexpected<Error> damaged(const std::filesystem::path& file) {
  return failure(ErrorCode::bad_input, file.string() +
                                           " can not be read; restore it from a copy, or remove it and add all "
                                           "operators anew");
}

}  // namespace

std::string_view to_string(Role role) {
  switch (role) {
    case Role::view: return "view";
    case Role::operate: return "operate";
    case Role::administer: break;
  }
  return "administer";
}

std::optional<Role> role_from(std::string_view text) {
  for (const Role role : {Role::view, Role::operate, Role::administer})
    if (to_string(role) == text) return role;
  return std::nullopt;
}

Result<std::unique_ptr<OperatorRegistry>> OperatorRegistry::open(const std::filesystem::path& file) {
  std::unique_ptr<OperatorRegistry> registry(new OperatorRegistry(file));
  if (auto done = registry->read(); !done) return tl::unexpected(done.error());
  return registry;
}

Result<void> OperatorRegistry::read() {
  const auto text = read_private_file(file_);
  if (!text && text.error().code == ErrorCode::not_found) return {};
  if (!text) return tl::unexpected(text.error());
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("operators") || !json["operators"].is_array()) return damaged(file_);
  for (const auto& row : json["operators"]) {
    if (!row.is_object() || !row.contains("name") || !row["name"].is_string() || !row.contains("expires_s") ||
        !row["expires_s"].is_number())
      return damaged(file_);
    const auto name = row["name"].get<std::string>();
    const auto role = role_from(row.value("role", ""));
    const auto digest = from_hex(row.value("digest", ""), digest_bytes);
    if (!role || !digest) return damaged(file_);
    entries_[name] = {{name, *role, row["expires_s"].get<double>()}, *digest};
  }
  return {};
}

Result<void> OperatorRegistry::write(const std::map<std::string, Entry>& entries) const {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& [name, entry] : entries)
    rows.push_back({{"name", name},
                    {"role", std::string(to_string(entry.who.role))},
                    {"expires_s", entry.who.expires_s},
                    {"digest", to_hex(entry.digest)}});
  return write_private_file(file_, nlohmann::json{{"operators", rows}}.dump(1) + "\n");
}

Result<std::string> OperatorRegistry::add(const std::string& name, Role role, double lifetime_s, double now_s) {
  if (auto ok = check_name("operator", name); !ok) return failure(ErrorCode::invalid_argument, ok.error().message);
  if (!(lifetime_s > 0 && lifetime_s <= most_lifetime_s))
    return failure(ErrorCode::invalid_argument, "a token is good for more than 0 and up to 3650 days");
  const std::string token = to_hex(random_secret(token_bytes));
  const std::lock_guard lock(mutex_);
  auto after = entries_;
  after[name] = {{name, role, now_s + lifetime_s}, sha256(token)};
  if (after.size() > most_operators)
    return failure(ErrorCode::refused,
                   "there are " + std::to_string(most_operators) + " operators already; revoke some first");
  if (auto written = write(after); !written) return tl::unexpected(written.error());
  entries_ = std::move(after);
  return token;
}

Result<void> OperatorRegistry::revoke(const std::string& name) {
  const std::lock_guard lock(mutex_);
  auto after = entries_;
  if (after.erase(name) == 0) return failure(ErrorCode::not_found, "there is no operator \"" + name + "\"");
  if (auto written = write(after); !written) return written;
  entries_ = std::move(after);
  return {};
}

std::vector<OperatorIdentity> OperatorRegistry::operators() const {
  const std::lock_guard lock(mutex_);
  std::vector<OperatorIdentity> all;
  all.reserve(entries_.size());
  for (const auto& [name, entry] : entries_) all.push_back(entry.who);
  return all;
}

std::optional<OperatorIdentity> OperatorRegistry::find(std::string_view token) const {
  const std::string digest = sha256(token);
  const std::lock_guard lock(mutex_);
  std::optional<OperatorIdentity> found;
  for (const auto& [name, entry] : entries_)  // compares with all of them, so that the time taken reveals nothing
    if (same_secret(digest, entry.digest)) found = entry.who;
  return found;
}

bool OperatorRegistry::stands(const OperatorIdentity& who, double now_s) const {
  if (who.name.empty()) return true;
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(who.name);
  return found != entries_.end() && found->second.who.expires_s == who.expires_s &&
         found->second.who.role == who.role && now_s < who.expires_s;
}

}  // namespace headframe
