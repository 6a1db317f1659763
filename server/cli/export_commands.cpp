// Files of what the server knows.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "server/cli/commands.hpp"
#include "server/cli/part_file.hpp"
#include "server/cli/progress.hpp"
#include "server/cli/table.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

constexpr double export_s = 3600;  // the server counts all points before it sends the first

std::string extension_of(const std::string& file) {
  const auto dot = file.rfind('.');
  return dot == std::string::npos || file.find('/', dot) != std::string::npos ? "" : file.substr(dot + 1);
}

/// What was asked for with --format, or else the file's ending.
Result<std::string> format_of(const std::string& file, const std::string& asked) {
  constexpr std::array known{"ply", "pcd", "las", "pdf", "svg", "png"};
  const std::string format = asked.empty() ? extension_of(file) : asked;
  for (const char* one : known)
    if (format == one) return format;
  return failure(
      ErrorCode::invalid_argument,
      file + " ends in none of .ply, .pcd, .las, .pdf, .svg and .png; the ending, or --format, chooses the format");
}

bool is_plan(const std::string& format) { return format == "pdf" || format == "svg" || format == "png"; }

/// "[##########----------]  50 %  1.0 MB of 2.0 MB"; without a total only what came.
std::string transfer_text(std::size_t received_bytes, std::uint64_t total_bytes) {
  constexpr std::size_t cells = 20;
  std::string received = bytes_text(static_cast<double>(received_bytes));
  if (total_bytes == 0) return received;
  const double share = std::min(static_cast<double>(received_bytes) / static_cast<double>(total_bytes), 1.0);
  const auto done = static_cast<std::size_t>(share * cells);
  std::ostringstream line;
  line << '[' << std::string(done, '#') << std::string(cells - done, '-') << "] " << std::setw(3)
       << static_cast<int>(100 * share) << " %  " << received << " of " << bytes_text(static_cast<double>(total_bytes));
  return line.str();
}

std::string in_frame(const std::string& frame) { return frame.empty() ? "" : "&frame=" + percent_encoded(frame); }

}  // namespace

Result<std::size_t> Commands::download(const std::string& target, const std::string& file, bool secret) {
  auto part = PartFile::create(file, secret);
  if (!part) return tl::unexpected(part.error());
  std::size_t received_bytes = 0;
  std::uint64_t total_bytes = 0;
  Progress line(isatty(STDERR_FILENO) != 0);
  HttpWatch watch;
  watch.waiting = [&](double waited_s) {
    if (received_bytes == 0) line.show("the server prepares the file: " + fixed(waited_s, 0) + " s");
  };
  watch.length = [&](std::uint64_t bytes) { total_bytes = bytes; };
  const auto response = HttpClient(endpoint_, {5, export_s})
                            .get(
                                target,
                                [&](std::string_view piece) {
                                  received_bytes += piece.size();
                                  line.show(transfer_text(received_bytes, total_bytes));
                                  return part->write(piece);
                                },
                                watch);
  if (!response) return tl::unexpected(response.error());
  if (response->status != 200) return tl::unexpected(error_of(*response));
  if (auto whole = part->commit(); !whole) return tl::unexpected(whole.error());
  return received_bytes;
}

Result<int> Commands::export_map(const MapRequest& request) {
  const auto format = format_of(request.file, request.format);
  if (!format) return tl::unexpected(format.error());
  const bool plan = is_plan(*format);
  if (request.scale && !plan)
    return failure(ErrorCode::invalid_argument,
                   "--scale is of a plan (pdf, svg, png), and " + request.file + " is " + *format + ": leave it out");
  if (request.voxel_m && plan)
    return failure(ErrorCode::invalid_argument,
                   "--voxel is of points (ply, pcd, las), and " + request.file + " is a plan: leave it out");
  const auto component = component_named(request.component);
  if (!component) return tl::unexpected(component.error());
  std::string target =
      (plan ? "/api/v1/plan?component=" : "/api/v1/export?component=") + *component + "&format=" + *format;
  if (request.scale) target += "&scale=" + std::to_string(*request.scale);
  if (request.voxel_m) target += "&voxel=" + fixed(*request.voxel_m, 4);
  const auto received_bytes = download(target + in_frame(request.frame), request.file);
  if (!received_bytes) return tl::unexpected(received_bytes.error());
  if (json_) {
    std::cout << Json{{"file", request.file}, {"component", *component}, {"bytes", *received_bytes}}.dump() << '\n';
  } else {
    std::cout << request.file << ": component " << *component << ", "
              << bytes_text(static_cast<double>(*received_bytes)) << '\n';
  }
  return exit_ok;
}

Result<int> Commands::trajectory(const std::string& session, const std::string& file, const std::string& frame) {
  const auto row = session_named(session);
  if (!row) return tl::unexpected(row.error());
  const auto robot = row->at("robot").get<std::string>();
  const auto name = row->at("session").get<std::string>();
  const auto received_bytes =
      download("/api/v1/trajectory?robot=" + percent_encoded(robot) + "&session=" + percent_encoded(name) +
                   (extension_of(file) == "csv" ? "&format=csv" : "") + in_frame(frame),
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

Result<int> Commands::backup(const std::string& file) {
  const auto received_bytes = download("/api/v1/backup", file, true);
  if (!received_bytes) return tl::unexpected(received_bytes.error());
  if (json_) {
    std::cout << Json{{"file", file}, {"bytes", *received_bytes}}.dump() << '\n';
  } else {
    std::cout << file << ": all of the base station, " << bytes_text(static_cast<double>(*received_bytes))
              << "; it holds the server's key and the operator's token. headframe-server --data NEW --restore " << file
              << " brings it back\n";
  }
  return exit_ok;
}

}  // namespace headframe
