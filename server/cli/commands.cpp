#include "server/cli/commands.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/cli/part_file.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double slice_s = 20;     // of a long wait: a server that died is noticed after one of these
constexpr double progress_s = 1;   // between two lines of progress
constexpr double export_s = 3600;  // the server counts all points before it sends the first

/// The line that the server wrote for people, or at least its status.
Error error_of(const HttpResponse& response) {
  const Json json = Json::parse(response.body, nullptr, false);
  if (json.is_object() && json.contains("error") && json["error"].is_object())
    return {ErrorCode::refused, json["error"].value("message", "HTTP status " + std::to_string(response.status))};
  return {ErrorCode::bad_input,
          "HTTP status " + std::to_string(response.status) + " and no reason; is this a headframe-server?"};
}

/// A progress line on stderr that overwrites itself on a terminal, and is written once for each change elsewhere.
class Progress {
 public:
  explicit Progress(bool wanted) : wanted_(wanted) {}
  ~Progress() {
    if (terminal_ && !last_.empty()) std::cerr << '\n';
  }
  void show(const std::string& line) {
    if (!wanted_ || line == last_) return;
    std::cerr << (terminal_ ? "\r\x1b[K" : "") << line << (terminal_ ? "" : "\n") << std::flush;
    last_ = line;
  }

 private:
  const bool wanted_;
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  std::string last_;
};

Result<std::string> format_of(const std::string& file) {
  const std::string extension = file.size() > 4 ? file.substr(file.size() - 4) : "";
  if (extension == ".ply" || extension == ".pcd" || extension == ".las") return extension.substr(1);
  return failure(ErrorCode::invalid_argument,
                 file + " ends in none of .ply, .pcd and .las; the ending chooses the format");
}

/// The one session that `wanted` names.
Result<Json> pick_session(const Json& sessions, const std::string& wanted) {
  std::vector<Json> of_robot;
  std::string there;
  for (const Json& row : sessions.at("sessions")) {
    const auto robot = row.at("robot").get<std::string>();
    const std::string full = robot + "/" + row.at("session").get<std::string>();
    if (full == wanted) return row;
    if (robot == wanted) of_robot.push_back(row);
    there += (there.empty() ? "" : ", ") + printable(full);
  }
  if (of_robot.size() == 1) return of_robot.front();
  const std::string problem = of_robot.empty() ? "there is no session \"" + wanted + "\""
                                               : "robot \"" + wanted + "\" has several sessions; say which";
  return failure(ErrorCode::not_found, problem + (there.empty() ? "; no session yet" : "; there are " + there));
}

}  // namespace

struct Commands::Waited {
  std::string body;
  Json json;
};

Result<std::string> Commands::fetched(const std::string& target, double silence_s) {
  auto response = HttpClient(endpoint_, {5, silence_s}).get(target);
  if (!response) return tl::unexpected(response.error());
  if (response->status != 200) return tl::unexpected(error_of(*response));
  return std::move(response->body);
}

Result<std::string> Commands::posted(const std::string& target, int status) {
  auto response = HttpClient(endpoint_).post(target);
  if (!response) return tl::unexpected(response.error());
  if (response->status != status) return tl::unexpected(error_of(*response));
  return std::move(response->body);
}

Result<int> Commands::status() {
  const auto body = fetched("/api/v1/status");
  if (!body) return tl::unexpected(body.error());
  std::cout << (json_ ? *body : status_view(Json::parse(*body)));
  return exit_ok;
}

Result<int> Commands::sessions() {
  const auto body = fetched("/api/v1/sessions");
  if (!body) return tl::unexpected(body.error());
  std::cout << (json_ ? *body : sessions_view(Json::parse(*body), terminal_width()));
  return exit_ok;
}

Result<int> Commands::atlas(std::optional<double> wait_s) {
  if (wait_s) {
    const auto waited = wait_for_idle(wait_s, false);
    return waited ? print_waited(*waited) : tl::unexpected(waited.error());
  }
  const auto body = fetched("/api/v1/atlas");
  if (!body) return tl::unexpected(body.error());
  std::cout << (json_ ? *body : atlas_view(Json::parse(*body), terminal_width()));
  return exit_ok;
}

Result<int> Commands::alignments() {
  const auto body = fetched("/api/v1/alignments");
  if (!body) return tl::unexpected(body.error());
  std::cout << (json_ ? *body : alignments_view(Json::parse(*body), terminal_width()));
  return exit_ok;
}

Result<int> Commands::decide(const std::string& decision, const std::string& alignment) {
  const auto done = HttpClient(endpoint_).post("/api/v1/alignments/" + percent_encoded(alignment) + "/" + decision);
  if (!done) return tl::unexpected(done.error());
  if (done->status != 200) return tl::unexpected(error_of(*done));
  std::cout << (json_ ? done->body : decision_view(Json::parse(done->body)));
  return exit_ok;
}

Result<int> Commands::explain(const std::string& a, const std::string& b) {
  const auto body = fetched("/api/v1/explain?a=" + percent_encoded(a) + "&b=" + percent_encoded(b));
  if (!body) return tl::unexpected(body.error());
  std::cout << (json_ ? *body : explanation_view(Json::parse(*body)));
  return exit_ok;
}

Result<int> Commands::merge(std::optional<double> wait_s) {
  const auto queued = HttpClient(endpoint_).post("/api/v1/merge");
  if (!queued) return tl::unexpected(queued.error());
  if (queued->status != 202) return tl::unexpected(error_of(*queued));
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
    auto body = fetched("/api/v1/atlas?wait=" + fixed(ask_s, 3), ask_s + 30);
    if (!body) return tl::unexpected(body.error());
    Waited waited{std::move(*body), {}};
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

Result<std::size_t> Commands::download(const std::string& target, const std::string& file) {
  auto part = PartFile::create(file);
  if (!part) return tl::unexpected(part.error());
  std::size_t received_bytes = 0;
  Progress line(isatty(STDERR_FILENO) != 0);
  const auto response = HttpClient(endpoint_, {5, export_s}).get(target, [&](std::string_view piece) {
    received_bytes += piece.size();
    line.show(bytes_text(static_cast<double>(received_bytes)));
    return part->write(piece);
  });
  if (!response) return tl::unexpected(response.error());
  if (response->status != 200) return tl::unexpected(error_of(*response));
  if (auto whole = part->commit(); !whole) return tl::unexpected(whole.error());
  return received_bytes;
}

Result<int> Commands::export_map(const std::string& component, const std::string& file, std::optional<double> voxel_m) {
  const auto format = format_of(file);
  if (!format) return tl::unexpected(format.error());
  std::string target = "/api/v1/export?component=" + percent_encoded(component) + "&format=" + *format;
  if (voxel_m) target += "&voxel=" + fixed(*voxel_m, 4);
  const auto received_bytes = download(target, file);
  if (!received_bytes) return tl::unexpected(received_bytes.error());
  if (json_) {
    std::cout << Json{{"file", file}, {"component", component}, {"bytes", *received_bytes}}.dump() << '\n';
  } else {
    std::cout << file << ": component " << component << ", " << bytes_text(static_cast<double>(*received_bytes))
              << '\n';
  }
  return exit_ok;
}

Result<int> Commands::trajectory(const std::string& session, const std::string& file) {
  const auto body = fetched("/api/v1/sessions");
  if (!body) return tl::unexpected(body.error());
  const auto row = pick_session(Json::parse(*body), session);
  if (!row) return tl::unexpected(row.error());
  const auto robot = row->at("robot").get<std::string>();
  const auto name = row->at("session").get<std::string>();
  const bool csv = file.size() > 4 && file.substr(file.size() - 4) == ".csv";
  const auto received_bytes = download("/api/v1/trajectory?robot=" + percent_encoded(robot) +
                                           "&session=" + percent_encoded(name) + (csv ? "&format=csv" : ""),
                                       file);
  if (!received_bytes) return tl::unexpected(received_bytes.error());
  if (json_) {
    std::cout << Json{{"file", file}, {"robot", robot}, {"session", name}, {"bytes", *received_bytes}}.dump() << '\n';
  } else {
    std::cout << file << ": " << printable(robot + "/" + name) << ", "
              << bytes_text(static_cast<double>(*received_bytes)) << '\n';
  }
  return exit_ok;
}

}  // namespace headframe
