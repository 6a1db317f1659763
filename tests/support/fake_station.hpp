#pragma once
// A station with two merged sessions, one apart and one rejected alignment, for tests of what the operator sees.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include "server/station/station.hpp"

namespace headframe {

class FakeStation : public Station {
 public:
  FakeStation() {
    for (SessionId id = 1; id <= 3; ++id) {
      SessionRow row;
      row.id = id;
      row.key = {id == 3 ? "gamma \"3\"" : id == 2 ? "beta" : "alpha", "run/1"};
      row.family = {"scan_context", 1};
      row.sensor = {"VLP-16", 16, 15, 15, 100};
      row.connected = id != 1;
      row.complete = id == 1;
      row.keyframes = 3;
      row.clouds = 2;
      row.bytes_received = 1000;
      row.distance_m = 12.5;
      row.trigger_to_transform_ms = id == 3 ? -1 : 420;
      rows.push_back(row);
    }
    Pose T_1_2 = pose_from_yaw(M_PI / 2, {10, 20, 30});
    view.atlas = {7, {{1, {{1, Pose::Identity()}, {2, T_1_2}}}, {3, {{3, Pose::Identity()}}}}};
    AlignmentRow published = row_of(1, 2, AlignmentState::published, T_1_2);
    published.alignment.evidence.probability = 0.97;
    published.alignment.evidence.tilt_deg = std::numeric_limits<double>::quiet_NaN();
    view.alignments.push_back(published);
    view.alignments.push_back(row_of(2, 3, AlignmentState::rejected, Pose::Identity()));
    work.standbys = 1;
  }
  ~FakeStation() override {
    timer_stop_.request_stop();
    if (timer_.joinable()) timer_.join();
  }

  std::vector<SessionRow> sessions() const override {
    const std::lock_guard lock(mutex_);
    return rows;
  }
  std::vector<ServerRecord> servers() const override {
    return {{"pit:/var/lib/headframe", "0.0.0.0:7447", "127.0.0.1:7448", true, true, 1.76e9, 0, 0},
            {"surface", "0.0.0.0:7447", "127.0.0.1:7448", false, false, 1.76e9 + 60, 1.2, 3, false, 17, 4, 9}};
  }
  AtlasView atlas() const override {
    const std::lock_guard lock(mutex_);
    return view;
  }
  /// Changes rows or view while the server looks at them.
  template <class Change>
  void change(Change what) {
    const std::lock_guard lock(mutex_);
    what();
  }
  Workload workload() const override {
    const std::lock_guard lock(mutex_);
    return work;
  }
  MergeConfig merge_config() const override { return {}; }
  Pending pending() const override {
    const std::lock_guard lock(mutex_);
    return pending_;
  }

  /// Like the real one: at once, on settle(), or when the time is over; one waiter is enough for a fake.
  void when_idle(double timeout_s, std::function<void(Pending)> callback) override {
    ++waits;
    const Pending now = pending();
    if (now.idle() || timeout_s == 0) return callback(now);
    if (timer_.joinable()) timer_.join();
    timer_ = std::jthread([this, timeout_s, callback = std::move(callback)] {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, timer_stop_.get_token(), std::chrono::duration<double>(timeout_s),
                        [this] { return pending_.idle(); });
      const Pending left = pending_;
      lock.unlock();
      callback(left);
    });
  }
  void merge_all() override {
    ++merges;
    if (merge_makes_work) set_pending({3, 0, 0});
  }
  /// Confirms, or says that there is no such alignment; on a thread of its own, as the real one.
  void decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> callback) override {
    const auto row = std::find_if(view.alignments.begin(), view.alignments.end(),
                                  [&](const AlignmentRow& r) { return r.alignment.id == alignment; });
    const bool known = row != view.alignments.end();
    if (known && decision == Decision::confirm) {
      row->alignment.state = AlignmentState::published;
      row->alignment.ruling = Ruling::confirmed;
    }
    decided.emplace_back(alignment, decision);
    deciding_ = std::jthread([known, callback = std::move(callback)] {
      if (known) return callback({});
      callback(failure(ErrorCode::not_found, "there is no such alignment"));
    });
  }
  /// Session 3 lies nowhere; all others fit where they were put, half a metre on.
  void place(SessionId a, SessionId b, const Pose& T_a_b,
             std::function<void(const Result<HandPlacement>&)> callback) override {
    if (a == 3 || b == 3) return callback(failure(ErrorCode::refused, "nobody has clouds where the two would meet"));
    HandPlacement placed{view.alignments.front().alignment, true, 0.5, 0.1};
    placed.alignment.state = placed.alignment.verdict = AlignmentState::candidate;
    placed.alignment.ruling = Ruling::placed;
    placed.alignment.T_a_b = a < b ? T_a_b : T_a_b.inverse();
    placed.alignment.evidence.inlier_fraction = 0.9;
    callback(placed);
  }
  void rename(SessionId session, const std::string& label, std::function<void(const Result<void>&)> callback) override {
    change([&] { rows.at(static_cast<std::size_t>(session) - 1).label = label; });
    callback({});
  }
  void anchor(SessionId session, std::function<void(const Result<void>&)> callback) override {
    anchored.push_back(session);
    callback({});
  }
  /// The robot of session 1 is away; of the others one cloud is missing.
  void request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> callback) override {
    if (session == 1) return callback(failure(ErrorCode::refused, "its robot is away"));
    callback(1);
  }
  void set_aside(SessionId session, const std::string& why,
                 std::function<void(const Result<void>&)> callback) override {
    change([&] { rows.at(static_cast<std::size_t>(session) - 1).why_aside = why; });
    callback({});
  }
  void release(SessionId session, std::function<void(const Result<void>&)> callback) override {
    std::string& why = rows.at(static_cast<std::size_t>(session) - 1).why_aside;
    if (why.empty()) return callback(failure(ErrorCode::refused, "the session is not set aside"));
    change([&] { why.clear(); });
    callback({});
  }
  void set_site(SessionId session, const std::string& site,
                std::function<void(const Result<void>&)> callback) override {
    change([&] { rows.at(static_cast<std::size_t>(session) - 1).site = site; });
    callback({});
  }
  void set_robot_site(const std::string& robot, const std::string& site,
                      std::function<void(const Result<void>&)> callback) override {
    change([&] { sites_of_robots[robot] = site; });
    callback({});
  }
  std::map<std::string, std::string> robot_sites() const override {
    const std::lock_guard lock(mutex_);
    return sites_of_robots;
  }
  void archive(SessionId session, bool archived, std::function<void(const Result<void>&)> callback) override {
    bool& now = rows.at(static_cast<std::size_t>(session) - 1).archived;
    if (now == archived) return callback(failure(ErrorCode::refused, "the session is archived already, or is not"));
    change([&] { now = archived; });
    callback({});
  }
  void freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> callback) override {
    change([&] { rows.at(static_cast<std::size_t>(session) - 1).frozen = frozen; });
    callback({});
  }
  void note(SessionId session, const std::string& note, std::function<void(const Result<void>&)> callback) override {
    change([&] { rows.at(static_cast<std::size_t>(session) - 1).note = note; });
    callback({});
  }
  void remove(SessionId session, std::function<void(const Result<void>&)> callback) override {
    change([&] { std::erase_if(rows, [&](const SessionRow& row) { return row.id == session; }); });
    callback({});
  }
  Result<std::optional<std::uint64_t>> free_bytes() const override {
    const std::lock_guard lock(mutex_);
    return free;
  }
  Result<std::vector<CoveredClouds>> covered_clouds() const override {
    const std::lock_guard lock(mutex_);
    return covered;
  }
  KeepPolicy keep_policy() const override { return keep; }
  void let_go(std::vector<CoveredClouds> clouds, std::function<void(const Result<void>&)> callback) override {
    change([&] {
      for (const CoveredClouds& of : clouds) {
        SessionRow& row = rows.at(static_cast<std::size_t>(of.session) - 1);
        row.clouds -= of.clouds.size();
        row.let_go += of.clouds.size();
        std::erase_if(covered, [&](const CoveredClouds& other) { return other.session == of.session; });
      }
    });
    callback({});
  }
  std::vector<Survey> surveys() const override {
    const std::lock_guard lock(mutex_);
    return surveyed;
  }
  void set_survey(const Survey& survey, std::function<void(const Result<void>&)> callback) override {
    change([&] { surveyed.push_back(survey); });
    callback({});
  }
  void drop_survey(SessionId session, std::function<void(const Result<void>&)> callback) override {
    std::size_t gone = 0;
    change([&] { gone = std::erase_if(surveyed, [&](const Survey& s) { return s.session == session; }); });
    if (gone > 0) return callback({});
    callback(failure(ErrorCode::not_found, "it has no survey"));
  }
  void set_pending(Pending pending) {
    const std::lock_guard lock(mutex_);
    pending_ = pending;
    changed_.notify_all();
  }

  Result<std::vector<Keyframe>> trajectory(SessionId session) const override {
    if (broken_trajectory) return failure(ErrorCode::bad_input, "the store's page 7 is damaged");
    std::vector<Keyframe> keyframes(3);
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
      keyframes[i].sequence = i + 1;
      keyframes[i].stamp_s = first_stamp_s + 100.0 * static_cast<double>(session) + static_cast<double>(i);
      keyframes[i].T_local_sensor.translation() = Eigen::Vector3d(static_cast<double>(i), 0, 0);
    }
    return keyframes;
  }

  Result<std::filesystem::path> backup() override {
    if (backup_file.empty()) return failure(ErrorCode::unavailable, "the disk is full");
    return backup_file;
  }

  /// Keyframes 1 and 2 have `points` points 1 m apart on the x axis, in two sweeps; 3 has none.
  Result<KeyframeCloud> cloud(SessionId session, std::uint64_t sequence) const override {
    ++clouds_read;
    const std::lock_guard gate(cloud_gate);
    if (sequence == 3 || sequence == withheld) return failure(ErrorCode::not_found, "no cloud");
    if (cloud_that_breaks == clouds_read) return failure(ErrorCode::bad_input, "a damaged cloud");
    KeyframeCloud out{{Sweep{}, Sweep{}}};
    if (floor) {
      for (int x = -40; x <= 40; ++x)
        for (int y = -40; y <= 40; ++y)
          out.sweeps[0].points.emplace_back(0.11F * static_cast<float>(x), 0.11F * static_cast<float>(y), 0.F);
      return out;
    }
    for (int i = 0; i < points; ++i)
      out.sweeps[static_cast<std::size_t>(i % 2)].points.emplace_back(static_cast<float>(i), 0.F,
                                                                      static_cast<float>(session));
    out.sweeps[1].points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.F, 0.F);
    // Of the sweep that has them: its first point's, and 10 more for each further one.
    if (session == painted)
      for (std::size_t i = 0; i < out.sweeps[1].points.size(); ++i)
        out.sweeps[1].intensity.push_back(static_cast<std::uint8_t>(100 + 10 * i));
    return out;
  }

  std::filesystem::path backup_file;
  std::vector<SessionRow> rows;
  AtlasView view;
  Workload work;
  std::map<std::string, std::string> sites_of_robots;
  std::optional<std::uint64_t> free = 1'000'000;
  std::vector<CoveredClouds> covered{{1, {{2, 600}, {3, 400}}, 1000, 2}, {2, {{1, 500}}, 500, 2}};
  KeepPolicy keep;
  int points = 10;
  double first_stamp_s = 0;
  SessionId painted = 0;       // whose clouds have intensities, in their second sweep
  std::uint64_t withheld = 0;  // the keyframe whose cloud has not come
  bool broken_trajectory = false;
  bool floor = false;         // clouds are a flat floor of 9 m around the sensor instead
  int cloud_that_breaks = 0;  // the n-th that is read
  bool merge_makes_work = false;
  std::atomic<int> merges = 0, waits = 0;
  std::vector<std::pair<AlignmentId, Decision>> decided;
  std::vector<SessionId> anchored;
  std::vector<Survey> surveyed;
  mutable std::atomic<int> clouds_read = 0;
  mutable std::mutex cloud_gate;  // held by a test: cloud() waits

 private:
  /// Of the first session and this one.
  AlignmentRow row_of(AlignmentId id, SessionId other, AlignmentState state, const Pose& T_a_b) const {
    AlignmentRow row;
    row.alignment.id = id;
    row.alignment.a = 1;
    row.alignment.b = other;
    row.alignment.state = state;
    row.alignment.T_a_b = T_a_b;
    row.a = rows[0].key;
    row.b = rows[static_cast<std::size_t>(other - 1)].key;
    return row;
  }
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  Pending pending_;
  std::stop_source timer_stop_;
  std::jthread timer_, deciding_;
};

}  // namespace headframe
