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

RevisionWatch::Seen RevisionWatch::finish() {
  thread_.request_stop();
  thread_.join();
  return seen_;
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
    look(json.at("revision").get<std::uint64_t>(), content);
    if (!sessions.empty()) (void)client.post("/api/v1/sessions/" + sessions[turn++ % sessions.size()] + "/anchor");
  }
}

void RevisionWatch::look(std::uint64_t revision, const std::string& content) {
  const auto [known, is_new] = content_.emplace(revision, content);
  const bool went_back = revision < content_.rbegin()->first;
  seen_.revisions += is_new ? 1 : 0;
  if (known->second == content && !went_back) return;
  ++seen_.contradictions;
  if (seen_.first.empty())
    seen_.first =
        "revision " + std::to_string(revision) +
        (went_back ? " after " + std::to_string(content_.rbegin()->first) : ": " + known->second + " and " + content);
}

}  // namespace headframe::bench
