// Which servers this base station has.
#include <nlohmann/json.hpp>

#include "server/cli/commands.hpp"
#include "server/cli/date.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {

using Json = nlohmann::json;

std::string servers_view(const Json& json, std::size_t width) {
  Table table{{{"server"},
               {"role"},
               {"robots"},
               {"operators", false, 1},
               {"since (UTC)", false, 2},
               {"heard", true},
               {"relayed", true, 3},
               {"searched", true, 3}},
              {}};
  for (const Json& server : json.at("servers")) {
    const auto text = [&](const char* key) { return printable(server.at(key).get<std::string>()); };
    table.rows.push_back({text("name"), text("role"), text("robots"), text("http"),
                          date_of(server.at("since_s").get<double>()),
                          fixed(server.at("heard_ago_s").get<double>(), 0) + " s ago",
                          std::to_string(server.value("relayed", 0)), std::to_string(server.value("searched", 0))});
  }
  return table.text(width);
}

Result<int> Commands::servers() { return printed(fetched("/api/v1/servers"), across_terminal(servers_view)); }

}  // namespace headframe
