// How much room there is for what robots send, and what goes for more.
#include <iostream>
#include <nlohmann/json.hpp>

#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {

using Json = nlohmann::json;

std::string covered_view(const Json& covered, std::size_t width) {
  if (covered.at("sessions").empty()) return "";
  Table table{{{"session"}, {"clouds", true}, {"of", true}, {"frees", true}}, {}};
  for (const Json& of : covered.at("sessions"))
    table.rows.push_back({printable(of.at("robot").get<std::string>() + "/" + of.at("session").get<std::string>()),
                          of.at("clouds").dump(), of.at("stored").dump(), bytes_text(of.at("bytes").get<double>())});
  return covered.at("clouds").dump() + " clouds, " + bytes_text(covered.at("bytes").get<double>()) +
         "; poses and descriptors stay:\n" + table.text(width);
}

std::string store_view(const Json& store, std::size_t width) {
  const Json& free = store.at("free_bytes");
  const Json& least = store.at("least_free_bytes");
  std::string out = "free        " + (free.is_null() ? "not known" : bytes_text(free.get<double>())) + "\n";
  out += "keep        " + store.at("keep").get<std::string>() +
         (least.is_null() ? ": clouds go only when you say so\n"
                          : ": covered clouds go while less than " + bytes_text(least.get<double>()) + " are free\n");
  out += "let go      " + store.at("let_go").dump() + " clouds so far\n";
  const std::string covered = covered_view(store.at("may_go"), width);
  return out + "may go      " + (covered.empty() ? "none: later sessions keep the rock of none\n" : covered);
}

Result<int> Commands::store() { return printed(fetched("/api/v1/store"), across_terminal(store_view)); }

Result<int> Commands::let_go(int mib, bool all_the_same) {
  constexpr double bytes_of_mib = 1024.0 * 1024.0;
  const std::string target = "/api/v1/store/let-go?bytes=" + fixed(mib == 0 ? 1e18 : mib * bytes_of_mib, 0);
  if (all_the_same)
    return printed(posted(target, 200), [](const Json& gone) {
      return gone.at("sessions").empty() ? "no cloud may go\n" : "gone: " + covered_view(gone, 0);
    });
  const auto body = fetched("/api/v1/store");
  if (!body) return tl::unexpected(body.error());
  const std::string covered = covered_view(Json::parse(*body).at("may_go"), 0);
  std::cerr << covered;
  return failure(ErrorCode::refused, covered.empty()
                                         ? "no cloud may go: later sessions keep the rock of none"
                                         : "nothing was deleted; what is deleted is gone for good: --yes does it, from "
                                           "the first line on" +
                                               std::string(mib == 0 ? "" : ", until so much is free"));
}

}  // namespace headframe
