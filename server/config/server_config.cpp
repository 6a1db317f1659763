#include "server/config/server_config.hpp"

#include <toml++/toml.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <variant>

namespace headframe {
namespace {

/// A key of the file, the member that it sets, and the range of a number.
struct Key {
  std::string_view section, name;
  std::variant<int*, double*, bool*, RegistrationEngine*, OperatorTls*, KeepClouds*, std::string*,
               std::optional<Endpoint>*>
      value;
  double low = 0, high = 0;
};

std::vector<Key> keys_of(ServerConfig& c) {
  return {
      {"server", "io_threads", &c.io_threads, 1, 64},
      {"server", "name", &c.name},
      {"server", "public", &c.public_address},
      {"store", "url", &c.store_url},
      {"store", "standby", &c.standby},
      {"store", "helps", &c.helps},
      {"store", "keep", &c.keep},
      {"store", "free_mib", &c.free_mib, 1, 1e9},
      {"store", "clouds_mib", &c.clouds_mib, 0, 1e9},
      {"operator", "tls", &c.operators.tls},
      {"operator", "certificate", &c.operators.certificate},
      {"operator", "key", &c.operators.key},
      {"limits", "database_mib", &c.database_mib, 0, 1e8},
      {"limits", "write_queue_mib", &c.write_queue_mib, 32, 65536},
      {"limits", "robots", &c.limits.robots, 1, 4096},
      {"limits", "sessions", &c.limits.sessions, 1, 4096},
      {"limits", "sessions_a_day", &c.limits.sessions_a_day, 1, 1e6},
      {"limits", "keyframes_a_day", &c.limits.keyframes_a_day, 1, 1e9},
      {"limits", "stored_mib_a_day", &c.limits.stored_mib_a_day, 1, 1e9},
      {"limits", "strangers", &c.limits.strangers, 1, 4096},
      {"limits", "spares", &c.limits.spares, 0, 64},
      {"limits", "undurable_mib", &c.limits.undurable_mib, 1, 1024},
      {"limits", "uplink_kib_s", &c.limits.uplink_kib_s, 0, 1e6},
      {"limits", "hello_s", &c.limits.hello_s, 0.1, 3600},
      {"limits", "silence_s", &c.limits.silence_s, 0.1, 3600},
      {"limits", "ping_s", &c.limits.ping_s, 0.1, 3600},
      {"limits", "write_s", &c.limits.write_s, 0.1, 3600},
      {"merge", "travelled_m", &c.schedule.travelled_m, 0.1, 1e6},
      {"merge", "junction_m", &c.schedule.junction_m, 0.1, 1e6},
      {"merge", "submap_s", &c.schedule.submap_s, 0.1, 3600},
      {"merge", "rest_s", &c.schedule.rest_s, 0.1, 1e6},
      {"merge", "asked_rest_s", &c.schedule.asked_rest_s, 0, 1e6},
      {"merge", "awaited_s", &c.schedule.awaited_s, 0, 3600},
      {"merge", "stuck_s", &c.schedule.stuck_s, 0.1, 1e6},
      {"merge", "budget_s", &c.schedule.budget_s, 0.1, 1e6},
      {"merge", "registration", &c.merge.registration},
      {"merge", "threads", &c.merge.threads, 1, 256},
      {"merge", "accept_probability", &c.merge.accept_probability, 0, 1},
      {"merge", "runner_up_share", &c.merge.runner_up_share, 0, 1},
      {"merge", "candidate_probability", &c.merge.candidate_probability, 0, 1},
      {"merge", "least_path_m", &c.merge.least_path_m, 0, 1e5},
      {"merge", "shown_m", &c.merge.shown_m, 0, 1e5},
      {"merge", "shown_more_m", &c.merge.shown_more_m, 0, 1e5},
      {"merge", "shown_doubt_m", &c.merge.shown_doubt_m, 0, 1e5},
      {"merge", "look_alikes", &c.merge.look_alikes, 0, 1e9},
      {"merge", "provisional_m", &c.merge.provisional_m, 0, 1e5},
      {"merge", "provisional_probability", &c.merge.provisional_probability, 0, 1},
      {"merge", "hypotheses", &c.merge.hypotheses, 1, 1000},
      {"merge", "partners", &c.merge.partners, 2, 10000},
      {"merge", "searches", &c.merge.searches, 1, 10000},
      {"merge", "clouds_requested", &c.merge.clouds_requested, 1, 1000},
      {"merge", "clouds_mb", &c.merge.clouds_mb, 1, 1e6},
      {"merge", "places_mb", &c.merge.places_mb, 1, 1e6},
      {"merge", "walls_mb", &c.merge.walls_mb, 1, 1e6},
  };
}

std::string place(const std::string& name, const toml::source_region& source) {
  return name + ":" + std::to_string(source.begin.line);
}

std::string known_names(const std::vector<Key>& keys, std::string_view section) {
  std::string names;
  for (const Key& key : keys)
    if (key.section == section) names += (names.empty() ? "" : ", ") + std::string(key.name);
  return names;
}

Result<void> set_engine(RegistrationEngine& engine, const toml::node& node, const std::string& where) {
  const auto name = node.value<std::string>().value_or("");
  if (name != "vgicp" && name != "pcl_gicp")
    return failure(ErrorCode::bad_input, where + ": registration must be \"vgicp\" or \"pcl_gicp\"");
  engine = name == "vgicp" ? RegistrationEngine::vgicp : RegistrationEngine::pcl_gicp;
  return {};
}

Result<void> set_tls(OperatorTls& tls, const toml::node& node, const std::string& where) {
  const auto name = node.value<std::string>().value_or("");
  if (name != "beyond_loopback" && name != "always" && name != "never")
    return failure(ErrorCode::bad_input, where + ": tls must be \"beyond_loopback\", \"always\" or \"never\"");
  tls = name == "never" ? OperatorTls::never : name == "always" ? OperatorTls::always : OperatorTls::beyond_loopback;
  return {};
}

Result<void> set_keep(KeepClouds& keep, const toml::node& node, const std::string& where) {
  const auto name = node.value<std::string>().value_or("");
  if (name != "all" && name != "newest")
    return failure(ErrorCode::bad_input, where + ": keep must be \"all\" or \"newest\"");
  keep = name == "all" ? KeepClouds::all : KeepClouds::newest;
  return {};
}

Result<void> set_file(std::string& file, std::string_view name, const toml::node& node, const std::string& where) {
  file = node.value<std::string>().value_or("");
  if (!file.empty()) return {};
  return failure(ErrorCode::bad_input, where + ": " + std::string(name) + " must be the name of a PEM file");
}

Result<void> set_url(std::string& url, const toml::node& node, const std::string& where) {
  url = node.value<std::string>().value_or("");
  if (url.starts_with("postgresql://") || url.starts_with("postgres://")) return {};
  return failure(ErrorCode::bad_input,
                 where +
                     ": url must begin with postgresql://; without url the server keeps an SQLite "
                     "database in --data");
}

Result<void> set_name(std::string& name, const toml::node& node, const std::string& where) {
  constexpr std::size_t most_bytes = 256;
  name = node.value<std::string>().value_or("");
  if (!name.empty() && name.size() <= most_bytes) return {};
  return failure(ErrorCode::bad_input, where + ": name must be text of 1 to " + std::to_string(most_bytes) + " bytes");
}

Result<void> set_address(std::optional<Endpoint>& address, const toml::node& node, const std::string& where) {
  auto peer = parse_peer(node.value<std::string>().value_or(""));
  if (!peer || is_any_address(*peer))
    return failure(ErrorCode::bad_input,
                   where + ": public must be \"HOST:PORT\", the address at which robots reach this server");
  address = std::move(*peer);
  return {};
}

Result<void> set_text(const Key& key, std::string& text, const toml::node& node, const std::string& where) {
  if (key.name == "url") return set_url(text, node, where);
  return key.name == "name" ? set_name(text, node, where) : set_file(text, key.name, node, where);
}

Result<void> set_switch(bool& on, std::string_view name, const toml::node& node, const std::string& where) {
  const auto value = node.value_exact<bool>();
  if (!value) return failure(ErrorCode::bad_input, where + ": " + std::string(name) + " must be true or false");
  on = *value;
  return {};
}

Result<void> set(const Key& key, const toml::node& node, const std::string& where) {
  if (auto* const* engine = std::get_if<RegistrationEngine*>(&key.value)) return set_engine(**engine, node, where);
  if (auto* const* tls = std::get_if<OperatorTls*>(&key.value)) return set_tls(**tls, node, where);
  if (auto* const* keep = std::get_if<KeepClouds*>(&key.value)) return set_keep(**keep, node, where);
  if (auto* const* on = std::get_if<bool*>(&key.value)) return set_switch(**on, key.name, node, where);
  if (auto* const* address = std::get_if<std::optional<Endpoint>*>(&key.value))
    return set_address(**address, node, where);
  if (auto* const* text = std::get_if<std::string*>(&key.value)) return set_text(key, **text, node, where);
  const bool whole = std::holds_alternative<int*>(key.value);
  const auto value = node.value<double>();
  if (!value || (whole && !node.is_integer()) || !(*value >= key.low && *value <= key.high)) {
    std::ostringstream text;
    text << where << ": " << key.name << " must be a " << (whole ? "whole number" : "number") << " from " << key.low
         << " to " << key.high;
    return failure(ErrorCode::bad_input, text.str());
  }
  if (whole)
    *std::get<int*>(key.value) = static_cast<int>(*value);
  else
    *std::get<double*>(key.value) = *value;
  return {};
}

Result<void> read_section(const std::vector<Key>& keys, std::string_view section, const toml::table& table,
                          const std::string& name) {
  for (const auto& [entry, node] : table) {
    const std::string where = place(name, node.source());
    const auto key = std::find_if(keys.begin(), keys.end(), [&, entry_name = entry.str()](const Key& k) {
      return k.section == section && k.name == entry_name;
    });
    if (key == keys.end())
      return failure(ErrorCode::bad_input, where + ": unknown key '" + std::string(entry.str()) + "' in [" +
                                               std::string(section) + "]; its keys are " + known_names(keys, section));
    if (auto done = set(*key, node, where); !done) return done;
  }
  return {};
}

}  // namespace

Result<ServerConfig> parse_config(std::string_view text, const std::string& name) {
  ServerConfig config;
  const auto keys = keys_of(config);
  try {
    const toml::table file = toml::parse(text);
    for (const auto& [entry, node] : file) {
      const std::string section(entry.str());
      if (!node.is_table() || known_names(keys, section).empty())
        return failure(ErrorCode::bad_input,
                       place(name, node.source()) + ": unknown section or key '" + section +
                           "'; the sections are [server], [store], [operator], [limits] and [merge]");
      if (auto done = read_section(keys, section, *node.as_table(), name); !done) return tl::unexpected(done.error());
    }
  } catch (const toml::parse_error& error) {
    return failure(ErrorCode::bad_input, place(name, error.source()) + ": " + std::string(error.description()));
  }
  if (!config.store_url.empty() && config.database_mib > 0)
    return failure(ErrorCode::bad_input,
                   name +
                       ": database_mib in [limits] is for SQLite only, but url in [store] selects "
                       "PostgreSQL; remove one of them");
  if (config.standby && config.store_url.empty())
    return failure(
        ErrorCode::bad_input,
        name +
            ": standby in [store] needs PostgreSQL, because only one server can use an SQLite database; set url in "
            "[store], or remove standby");
  if (config.clouds_mib > 0 && config.store_url.empty())
    return failure(ErrorCode::bad_input,
                   name +
                       ": clouds_mib in [store] is for PostgreSQL only; remove it (database_mib in "
                       "[limits] limits SQLite's file), or set url in [store]");
  if (config.keep == KeepClouds::newest && !config.store_url.empty() && config.clouds_mib == 0)
    return failure(ErrorCode::bad_input,
                   name +
                       ": keep = \"newest\" in [store] needs to know how much space clouds may take in "
                       "PostgreSQL; set clouds_mib in [store]");
  if (config.clouds_mib > 0 && config.clouds_mib <= config.free_mib)
    return failure(ErrorCode::bad_input, name + ": clouds_mib in [store] is " + std::to_string(config.clouds_mib) +
                                             "; it must be larger than free_mib, " + std::to_string(config.free_mib));
  const OperatorConfig& operators = config.operators;
  if (operators.certificate.empty() && !operators.key.empty())
    return failure(ErrorCode::bad_input,
                   name + ": [operator] has a key but no certificate; set certificate, or remove key");
  if (operators.tls == OperatorTls::never && !operators.certificate.empty())
    return failure(ErrorCode::bad_input,
                   name + ": [operator] has a certificate, but tls = \"never\" does not use it; remove one of them");
  return config;
}

Result<ServerConfig> load_config(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return failure(ErrorCode::not_found,
                   "cannot read the configuration file " + path.string() + "; check its name and permissions");
  return parse_config(std::string(std::istreambuf_iterator<char>(file), {}), path.string());
}

}  // namespace headframe
