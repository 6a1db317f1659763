#include "client/tools/replay_report.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace headframe {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto bar_every = std::chrono::milliseconds(100);
constexpr auto line_every = std::chrono::seconds(5);

std::string name(const SessionKey& key) { return key.robot + "/" + key.session; }

std::string megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

std::string pose(const Pose& T) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f) m, yaw %.1f deg", T.translation().x(), T.translation().y(),
                T.translation().z(), yaw_rad(T) * 180 / std::numbers::pi);
  return text;
}

/// Empty: there is something to say.
std::string nothing_of(const std::string& what, const SurroundingsTold& told) {
  using State = SurroundingsTold::State;
  if (told.state == State::unsupported) return what + ": this server is too old to tell; update it";
  return told.state == State::none ? what + ": " + told.missing : "";
}

double length_m(const std::vector<Eigen::Vector3d>& path_m) {
  double sum_m = 0;
  for (std::size_t i = 1; i < path_m.size(); ++i) sum_m += (path_m[i] - path_m[i - 1]).norm();
  return sum_m;
}

}  // namespace

std::string describe(const Progress& p) {
  std::string text = std::to_string(p.keyframes) + " keyframes (" + std::to_string(p.keyframes_acknowledged) +
                     " acknowledged), " + std::to_string(p.clouds_waiting + p.clouds_acknowledged) + " clouds (" +
                     std::to_string(p.clouds_acknowledged) + " acknowledged), " + megabytes(p.bytes_sent) + " sent";
  if (p.clouds_dropped > 0) text += ", " + std::to_string(p.clouds_dropped) + " clouds dropped";
  if (p.clouds_refused > 0) text += " (" + p.cloud_error + ")";
  return text;
}

ReplayReport::ReplayReport(std::size_t scans) : scans_(scans), terminal_(::isatty(STDOUT_FILENO) == 1) {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 12);  // so that a reader of a pipe gets each line when it is written
}

void ReplayReport::line(const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  clear_bar();
  std::printf("%s\n", text.c_str());
  draw_bar();
}

void ReplayReport::warning(const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  clear_bar();
  std::fprintf(stderr, "headframe-replay: %s\n", text.c_str());
  draw_bar();
}

void ReplayReport::step(std::size_t scans_done, const Progress& progress) {
  if (!progress.cut.empty() && progress.cut != cut_) warning(progress.cut);
  cut_ = progress.cut;
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto now = Clock::now();
  if (drawn_ != Clock::time_point{} &&
      now - drawn_ < (terminal_ ? Clock::duration(bar_every) : Clock::duration(line_every)))
    return;
  const bool first = drawn_ == Clock::time_point{};
  drawn_ = now;
  const std::string status = std::to_string(scans_done) + "/" + std::to_string(scans_) + " scans, " +
                             describe(progress) + (progress.connected ? "" : ", not connected");
  if (!terminal_) {
    if (!first && status != status_) std::printf("%s\n", status.c_str());
    status_ = status;
    return;
  }
  constexpr std::size_t width = 20;
  const std::size_t full = scans_ == 0 ? width : width * scans_done / scans_;
  clear_bar();
  bar_ = std::string(full, '#') + std::string(width - full, '.') + " " + status;
  draw_bar();
}

void ReplayReport::transforms(const SessionKey& mine, const Transforms& t) {
  std::string text = "transforms, revision " + std::to_string(t.revision) + ": anchor " + name(t.anchor);
  if (const auto T = t.T_component(mine)) text += "; T_component_mine " + pose(*T);
  for (const auto& s : t.sessions)
    if (const auto T = t.T_mine_other(mine, s.session); T && s.session != mine)
      text += "; T_mine_" + name(s.session) + " " + pose(*T);
  for (const auto& p : t.provisional)
    text += "; provisional, nothing to drive by: " + name(p.session) + ", " + std::to_string(std::lround(p.awaited_m)) +
            " m awaited, T_component " + pose(p.T_component_session);
  line(text);
  for (const auto& w : t.withdrawn) {
    if (w.revision <= withdrawn_known_) continue;
    withdrawn_known_ = w.revision;
    line("WITHDRAWN: the transform between " + name(w.a) + " and " + name(w.b) + ": " + w.reason);
  }
}

void ReplayReport::localization(const Localization& l) {
  using State = Localization::State;
  if (l.state == State::unsupported) return line("where am I: this server is too old to tell; update it");
  char text[160];
  if (l.state == State::not_yet) {
    std::snprintf(text, sizeof text,
                  "where am I, keyframe %llu: not yet: ", static_cast<unsigned long long>(l.keyframe));
    return line(text + l.missing);
  }
  std::snprintf(text, sizeof text, ", probability %.3f, %.0f m shared, +- %.2f m, %.1f deg", l.probability, l.shared_m,
                std::sqrt(l.covariance.topLeftCorner<3, 3>().trace()),
                std::sqrt(l.covariance(5, 5)) * 180 / std::numbers::pi);
  line("where am I, keyframe " + std::to_string(l.keyframe) + ": on the map of " + name(l.session) + ", in " +
       name(l.anchor) + "'s frame: T_component_sensor " + pose(l.T_component_sensor) + text +
       (l.merged ? ", merged" : ""));
}

void ReplayReport::trajectories(const Trajectories& t) {
  if (const std::string nothing = nothing_of("paths of others", t); !nothing.empty()) return line(nothing);
  std::string text = "paths of others, revision " + std::to_string(t.revision) + ":";
  for (const auto& path : t.paths) {
    text += " " + name(path.session) + " " + std::to_string(std::lround(length_m(path.p_local_m))) + " m";
    if (path.age_s) text += ", " + std::to_string(std::lround(*path.age_s / 60)) + " min ago";
    text += ";";
  }
  line(text);
}

void ReplayReport::coverage(const Coverage& c) {
  if (const std::string nothing = nothing_of("coverage", c); !nothing.empty()) return line(nothing);
  std::size_t seen = 0, gone = 0;
  for (const auto& [index, tile] : c.tiles)
    for (const CoverageCell& cell : tile->cells) {
      seen += cell.what != 0 ? 1 : 0;
      gone += (cell.what & coverage_path) != 0 ? 1 : 0;
    }
  line("coverage, revision " + std::to_string(c.revision) + ": " + std::to_string(seen) + " m2 seen, " +
       std::to_string(gone) + " m2 driven through, by " + std::to_string(c.sessions.size()) + " sessions");
}

void ReplayReport::map(const MapAround& m) {
  if (!m.refused.empty()) return line("map: " + m.refused);
  line("map, revision " + std::to_string(m.revision) + ": " + std::to_string(m.points.size()) + " points of " +
       std::to_string(m.clouds) + " clouds" +
       (m.clouds_left_out > 0 ? ", " + std::to_string(m.clouds_left_out) + " older ones left out" : ""));
}

void ReplayReport::end(const Progress& progress) {
  const std::lock_guard<std::mutex> lock(mutex_);
  clear_bar();
  bar_.clear();
  std::printf("%s\n", describe(progress).c_str());
}

void ReplayReport::clear_bar() {
  if (!bar_.empty()) std::printf("\r\033[K");
  std::fflush(stdout);
}

void ReplayReport::draw_bar() {
  if (bar_.empty()) return;
  std::printf("%s", bar_.c_str());
  std::fflush(stdout);
}

}  // namespace headframe
