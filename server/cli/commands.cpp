#include "server/cli/commands.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/cli/progress.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double slice_s = 20;    // of a long wait: a server that died is noticed after one of these
constexpr double progress_s = 1;  // between two lines of progress

}  // namespace

Error error_of(const HttpResponse& response) {
  const Json json = Json::parse(response.body, nullptr, false);
  if (json.is_object() && json.contains("error") && json["error"].is_object())
    return {ErrorCode::refused, json["error"].value("message", "HTTP status " + std::to_string(response.status))};
  return {ErrorCode::bad_input,
          "HTTP status " + std::to_string(response.status) + " and no reason; is this a headframe-server?"};
}

struct Commands::Waited {
  std::string body;
  Json json;
};

Result<std::string> Commands::wanted(const HttpRequest& ask, int status, double silence_s) {
  Progress line(isatty(STDERR_FILENO) != 0);
  HttpWatch watch;
  watch.waiting = [&](double waited_s) { line.show("the server is at it: " + fixed(waited_s, 0) + " s"); };
  auto response = ask(HttpClient(endpoint_, {5, silence_s}), watch);
  if (!response) return tl::unexpected(response.error());
  if (response->status != status) return tl::unexpected(error_of(*response));
  return std::move(response->body);
}

Result<std::string> Commands::fetched(const std::string& target) {
  return wanted([&](HttpClient client, const HttpWatch& watch) { return client.get(target, {}, watch); });
}

Result<std::string> Commands::posted(const std::string& target, int status, const std::string& body) {
  return wanted([&](HttpClient client, const HttpWatch& watch) { return client.post(target, body, watch); }, status);
}

Result<std::string> Commands::removed(const std::string& target) {
  return wanted([&](HttpClient client, const HttpWatch& watch) { return client.remove(target, watch); });
}

Result<int> Commands::printed(const Result<std::string>& body, const View& view) {
  if (!body) return tl::unexpected(body.error());
  std::cout << (json_ ? *body : view(Json::parse(*body)));
  return exit_ok;
}

Result<Json> Commands::session_named(const std::string& wanted) {
  const auto body = fetched("/api/v1/sessions");
  if (!body) return tl::unexpected(body.error());
  std::vector<Json> fitting;
  std::string there;
  const Json sessions = Json::parse(*body);
  for (const Json& row : sessions.at("sessions")) {
    const auto robot = row.at("robot").get<std::string>();
    const std::string full = robot + "/" + row.at("session").get<std::string>();
    if (full == wanted) return row;
    if (robot == wanted || row.value("label", Json()) == Json(wanted)) fitting.push_back(row);
    there.append(there.empty() ? "" : ", ").append(printable(full));
  }
  if (fitting.size() == 1) return fitting.front();
  const std::string problem = fitting.empty() ? "there is no session \"" + wanted + "\""
                                              : "\"" + wanted + "\" means several sessions; say which";
  return failure(ErrorCode::not_found, problem + (there.empty() ? "; no session yet" : "; there are " + there));
}

Result<std::string> Commands::component_named(const std::string& wanted) {
  if (!wanted.empty() && wanted.find_first_not_of("0123456789") == std::string::npos) return wanted;
  const auto row = session_named(wanted);
  if (!row && row.error().code == ErrorCode::not_found)
    return failure(row.error().code, "--component: " + row.error().message);
  if (!row) return tl::unexpected(row.error());
  if (!row->at("component").is_null()) return row->at("component").dump();
  return failure(ErrorCode::not_found, "--component: " + wanted + " has no map yet");
}

Result<int> Commands::status() { return printed(fetched("/api/v1/status"), status_view); }

Result<int> Commands::sessions() { return printed(fetched("/api/v1/sessions"), across_terminal(sessions_view)); }

Result<int> Commands::atlas(std::optional<double> wait_s) {
  if (wait_s) {
    const auto waited = wait_for_idle(wait_s, false);
    return waited ? print_waited(*waited) : tl::unexpected(waited.error());
  }
  return printed(fetched("/api/v1/atlas"), across_terminal(atlas_view));
}

Result<int> Commands::alignments(int most_rejected) {
  return printed(fetched("/api/v1/alignments?most=" + std::to_string(most_rejected)), across_terminal(alignments_view));
}

Result<int> Commands::changes(double since_s) {
  return printed(fetched("/api/v1/changes?since=" + fixed(since_s, 0)), across_terminal(changes_view));
}

/// Whether there is nothing against confirming it. One that is not known is the server's to refuse.
Result<void> Commands::check_confirm(const std::string& alignment) {
  constexpr double doubtful = 0.5;
  const auto body = fetched("/api/v1/alignments?id=" + percent_encoded(alignment));
  if (!body) return tl::unexpected(body.error());
  const Json all = Json::parse(*body);
  for (const Json& row : all.at("alignments")) {
    if (row.at("id").dump() != alignment) continue;
    const auto state = row.at("state").get<std::string>();
    const double probability = row.at("evidence").value("probability", 0.0);
    if (state == "published" || (state != "verified" && probability >= doubtful)) return {};
    const std::string why =
        state == "verified" ? "other sessions contradict it" : "its probability is " + fixed(probability, 3);
    const auto name = [](const Json& key) {
      return key.at("robot").get<std::string>().append("/").append(key.at("session").get<std::string>());
    };
    std::string line = "alignment " + alignment;
    line.append(", ").append(name(row.at("a"))).append(" and ").append(name(row.at("b"))).append(": ").append(why);
    line.append(", and a wrong merge sends robots wrong transforms; headframe confirm ").append(alignment);
    return failure(ErrorCode::refused, line.append(" --yes confirms it all the same"));
  }
  return {};
}

Result<int> Commands::decide(const std::string& decision, const std::string& alignment, bool all_the_same) {
  if (decision == "confirm" && !all_the_same)
    if (auto clear = check_confirm(alignment); !clear) return tl::unexpected(clear.error());
  return printed(posted("/api/v1/alignments/" + percent_encoded(alignment) + "/" + decision, 200), decision_view);
}

Result<int> Commands::explain(const std::string& a, const std::string& b) {
  return printed(fetched("/api/v1/explain?a=" + percent_encoded(a) + "&b=" + percent_encoded(b)), explanation_view);
}

Result<int> Commands::merge(std::optional<double> wait_s) {
  const auto queued = posted("/api/v1/merge", 202);
  if (!queued) return tl::unexpected(queued.error());
  const auto waited = wait_for_idle(wait_s, true);
  return waited ? print_waited(*waited) : tl::unexpected(waited.error());
}

Result<int> Commands::watch(double every_s, int times) {
  const bool terminal = isatty(STDOUT_FILENO) != 0 && !json_;
  for (int shown = 1;; ++shown) {
    const auto status = fetched("/api/v1/status"), sessions = fetched("/api/v1/sessions");
    if (!status) return tl::unexpected(status.error());
    if (!sessions) return tl::unexpected(sessions.error());
    if (terminal) std::cout << "\x1b[H\x1b[2J";
    if (json_) {
      std::cout << *status << std::flush;
    } else {
      std::cout << status_view(Json::parse(*status)) << '\n'
                << sessions_view(Json::parse(*sessions), terminal_width()) << std::flush;
    }
    if (shown == times) return exit_ok;
    std::this_thread::sleep_for(std::chrono::duration<double>(every_s));
  }
}

Result<Commands::Waited> Commands::wait_for_idle(std::optional<double> wait_s, bool progress) {
  const auto start = Clock::now();
  Progress line(progress);
  while (true) {
    const double passed_s = std::chrono::duration<double>(Clock::now() - start).count();
    const double left_s = wait_s ? std::max(0.0, *wait_s - passed_s) : slice_s;
    const double ask_s = std::min(left_s, progress ? progress_s : slice_s);
    auto response = HttpClient(endpoint_, {5, ask_s + 30}).get("/api/v1/atlas?wait=" + fixed(ask_s, 3));
    if (!response) return tl::unexpected(response.error());
    if (response->status != 200) return tl::unexpected(error_of(*response));
    Waited waited{std::move(response->body), {}};
    waited.json = Json::parse(waited.body);
    const bool settled = !waited.json.at("waited_out").get<bool>();
    line.show(settled ? "settled" : "pending: " + pending_view(waited.json.at("pending")));
    if (settled || ask_s >= left_s) return waited;
  }
}

Result<int> Commands::print_waited(const Waited& waited) {
  std::cout << (json_ ? waited.body : atlas_view(waited.json, terminal_width())) << std::flush;
  if (!waited.json.at("waited_out").get<bool>()) return exit_ok;
  std::cerr << "headframe: the time is over; still pending: " << pending_view(waited.json.at("pending")) << '\n';
  return exit_waited_out;
}

}  // namespace headframe
