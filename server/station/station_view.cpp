#include "server/station/station_view.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/steady_timer.hpp>

#include "common/cloud/cloud_codec.hpp"
#include "server/station/cloud_keeping.hpp"
#include "server/support/stopwatch.hpp"

namespace headframe {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto look_again = std::chrono::milliseconds(20);

struct Wait : std::enable_shared_from_this<Wait> {
  Wait(boost::asio::io_context& io, const Station& the_station) : timer(io), station(the_station) {}

  void look() {
    const Pending pending = station.pending();
    if (pending.idle() || Clock::now() >= deadline) return callback(pending);
    timer.expires_after(look_again);
    timer.async_wait([self = shared_from_this()](boost::system::error_code error) {
      if (!error) self->look();
    });
  }

  boost::asio::steady_timer timer;
  const Station& station;
  Clock::time_point deadline;
  std::function<void(Pending)> callback;
};

}  // namespace

std::vector<SessionRow> StationView::sessions() const {
  auto rows = hub_.sessions();
  const auto view = worker_.view();
  const auto labels = notes_.labels(), notes = notes_.notes();
  for (SessionRow& row : rows) {
    if (const auto label = labels.find(row.id); label != labels.end()) row.label = label->second;
    if (const auto note = notes.find(row.id); note != notes.end()) row.note = note->second;
    const auto it = view->sessions.find(row.id);
    if (it == view->sessions.end()) continue;
    row.distance_m = it->second.distance_m;
    row.why_aside = it->second.why_aside;
    row.archived = it->second.archived;
    row.frozen = it->second.frozen;
    row.site = it->second.site;  // from the same moment as the merges
    row.trigger_to_transform_ms = it->second.trigger_to_transform_ms;
  }
  return rows;
}

AtlasView StationView::atlas() const {
  const auto view = worker_.view();  // before the keys, so that every session in it has one
  const auto keys = hub_.keys();
  AtlasView atlas{view->atlas, {}, view->corrections};
  for (const Alignment& alignment : view->alignments)
    atlas.alignments.push_back({alignment, keys.at(alignment.a), keys.at(alignment.b)});
  return atlas;
}

Pending StationView::pending() const {
  const std::size_t unsettled = hub_.unsettled();  // before the worker's, which counts what is settled in between
  Pending pending = worker_.pending();
  pending.keyframes += unsettled;
  return pending;
}

Workload StationView::workload() const {
  const StoreLoad load = store_.load();
  Workload work;
  work.queued_writes = load.queued_writes;
  work.queued_bytes = load.queued_bytes;
  work.durable_writes = load.durable_writes;
  work.failed_writes = load.failed_writes;
  work.disk_error = load.last_error;
  work.effort = worker_.effort();
  work.commits = load.commits;
  work.commit_s = load.commit_s;
  work.waiting_orders = worker_.waiting_orders();
  if (const auto piece = worker_.working_on_now()) work.merge_work_s = ms_since(piece->began) / 1000;
  work.damaged_keyframes = load.damaged_keyframes;
  {
    const std::lock_guard lock(mutex_);
    work.damaged_clouds = damaged_clouds_.size();
  }
  work.merge_stuck = worker_.stuck();
  for (const ServerRecord& server : servers()) work.standbys += server.is_active || server.is_self ? 0 : 1;
  return work;
}

std::vector<ServerRecord> StationView::servers() const { return servers_ ? servers_() : std::vector<ServerRecord>(); }

LinkHealth StationView::link_health() const {
  const LinkCounts& counts = hub_.counts();
  return {hub_.policy().hold, store_.load().queued_bytes, counts.refused,        counts.replaced,  counts.failed,
          counts.stuck,       counts.held_back,           counts.refused_clouds, counts.sent_bytes};
}

void StationView::when_idle(double timeout_s, std::function<void(Pending)> callback) {
  auto wait = std::make_shared<Wait>(io_, *this);
  wait->deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s));
  wait->callback = std::move(callback);
  wait->look();
}

void StationView::merge_all() {
  for (const auto& [session, key] : hub_.keys()) worker_.trigger(session, Trigger::command);
}

void StationView::decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> callback) {
  worker_.decide(alignment, decision, std::move(callback));
}

void StationView::rename(SessionId session, const std::string& label,
                         std::function<void(const Result<void>&)> callback) {
  notes_.rename(session, label, std::move(callback));
}

void StationView::anchor(SessionId session, std::function<void(const Result<void>&)> callback) {
  worker_.anchor(session, std::move(callback));
}

void StationView::request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> callback) {
  worker_.request_clouds(session, std::move(callback));
}

void StationView::set_aside(SessionId session, const std::string& why,
                            std::function<void(const Result<void>&)> callback) {
  worker_.set_aside(session, why, std::move(callback));
}

void StationView::release(SessionId session, std::function<void(const Result<void>&)> callback) {
  worker_.release(session, std::move(callback));
}

void StationView::remove(SessionId session, std::function<void(const Result<void>&)> callback) {
  worker_.remove(session, [this, session, callback = std::move(callback)](const Result<void>& done) {
    if (done) hub_.forget(session);
    callback(done);
  });
}

void StationView::set_site(SessionId session, const std::string& site,
                           std::function<void(const Result<void>&)> callback) {
  if (auto named = site.empty() ? Result<void>() : check_name("site", site); !named)
    return callback(failure(ErrorCode::invalid_argument, named.error().message));
  worker_.set_site(session, site, [this, session, site, callback = std::move(callback)](const Result<void>& done) {
    if (done) hub_.set_site(session, site);
    callback(done);
  });
}

void StationView::set_robot_site(const std::string& robot, const std::string& site,
                                 std::function<void(const Result<void>&)> callback) {
  hub_.set_robot_site(robot, site, std::move(callback));
}

std::map<std::string, std::string> StationView::robot_sites() const { return hub_.robot_sites(); }

void StationView::archive(SessionId session, bool archived, std::function<void(const Result<void>&)> callback) {
  worker_.archive(session, archived, std::move(callback));
}

void StationView::freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> callback) {
  worker_.freeze(session, frozen, std::move(callback));
}

void StationView::note(SessionId session, const std::string& note, std::function<void(const Result<void>&)> callback) {
  notes_.note(session, note, std::move(callback));
}

void StationView::set_survey(const Survey& survey, std::function<void(const Result<void>&)> callback) {
  notes_.set_survey(survey, std::move(callback));
}

void StationView::drop_survey(SessionId session, std::function<void(const Result<void>&)> callback) {
  notes_.drop_survey(session, std::move(callback));
}

Result<std::vector<CoveredClouds>> StationView::covered_clouds() const {
  const auto view = worker_.view();
  return headframe::covered_clouds(store_, {sessions(), view->atlas, view->corrections, view->alignments});
}

void StationView::let_go(std::vector<CoveredClouds> clouds, std::function<void(const Result<void>&)> callback) {
  headframe::let_go(store_, clouds,
                    {[this](SessionId session, const std::vector<std::uint64_t>& sequences) {
                       worker_.clouds_let_go(session, sequences);
                       hub_.let_go(session, sequences);
                     },
                     std::move(callback)});
}

Result<std::vector<Keyframe>> StationView::trajectory(SessionId session) const {
  std::vector<Keyframe> keyframes;
  const auto read = store_.each_keyframe(session, 1, [&](const Keyframe& keyframe) {
    Keyframe& kept = keyframes.emplace_back();
    kept.sequence = keyframe.sequence;
    kept.stamp_s = keyframe.stamp_s;
    kept.T_local_sensor = keyframe.T_local_sensor;
    kept.point_count = keyframe.point_count;
  });
  if (!read) return tl::unexpected(read.error());
  return keyframes;
}

Result<KeyframeCloud> StationView::cloud(SessionId session, std::uint64_t sequence) const {
  const KeyframeRef keyframe{session, sequence};
  const auto encoded = store_.cloud(keyframe);
  if (!encoded && encoded.error().code != ErrorCode::bad_input) return tl::unexpected(encoded.error());
  if (!encoded) return tl::unexpected(damaged(keyframe, encoded.error()));
  auto cloud = decode_cloud(*encoded);
  if (!cloud) return tl::unexpected(damaged(keyframe, cloud.error()));
  return cloud;
}

/// Logged only once for each cloud.
Error StationView::damaged(const KeyframeRef& cloud, const Error& why) const {
  const std::string what = "the stored cloud of keyframe " + std::to_string(cloud.sequence) + " of session " +
                           std::to_string(cloud.session) + " is damaged: " + why.message;
  const std::lock_guard lock(mutex_);
  if (damaged_clouds_.insert(cloud).second) spdlog::error("{}", what);
  return {ErrorCode::not_found, what};
}

}  // namespace headframe
