#include "tests/bench/servers/revision_watch.hpp"

#include <chrono>
#include <nlohmann/json.hpp>

#include "server/cli/http_client.hpp"

namespace headframe::bench {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

constexpr HttpTimeouts impatient{.connect_s = 1, .silence_s = 5};

struct Merged {
  std::vector<std::string> sessions;  // ids; the anchor of these can be chosen
  std::string content;                // where each lies in which component
};

/// Of the components with several sessions: of the others a revision says nothing.
Merged merged(const Json& atlas) {
  Merged all;
  for (const Json& component : atlas.at("components")) {
    if (component.at("sessions").size() < 2) continue;
    all.content += "component " + component.at("id").dump();
    for (const Json& session : component.at("sessions")) {
      all.sessions.push_back(session.at("id").dump());
      all.content += " " + all.sessions.back() + " at " + session.at("T_component_session").dump();
    }
  }
  return all;
}

}  // namespace

RevisionWatch::RevisionWatch(std::function<std::string()> http, std::string token)
    : http_(std::move(http)), token_(std::move(token)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

RevisionBook::Seen RevisionWatch::finish() {
  thread_.request_stop();
  thread_.join();
  return book_.seen();
}

void RevisionWatch::run(const std::stop_token& stop) {
  for (std::size_t turn = 0; !stop.stop_requested(); std::this_thread::sleep_for(50ms)) {
    auto endpoint = parse_http_endpoint(http_());
    if (!endpoint) continue;
    endpoint->token = token_;
    HttpClient client(*endpoint, impatient);
    const auto atlas = client.get("/api/v1/atlas");
    if (!atlas || atlas->status != 200) continue;
    const Json json = Json::parse(atlas->body);
    const auto [sessions, content] = merged(json);
    book_.look(json.at("revision").get<std::uint64_t>(), content);
    if (!sessions.empty()) (void)client.post("/api/v1/sessions/" + sessions[turn++ % sessions.size()] + "/anchor");
  }
}

}  // namespace headframe::bench
