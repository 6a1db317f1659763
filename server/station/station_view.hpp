#pragma once

#include <boost/asio/io_context.hpp>
#include <mutex>
#include <set>

#include "server/merge_worker/merge_worker.hpp"
#include "server/net/session_hub.hpp"
#include "server/station/station.hpp"
#include "server/station/station_notes.hpp"

namespace headframe {

/// Implements Station on hub, worker, store and notes. All of them must outlive it; so must `io`, on which it waits.
class StationView : public Station {
 public:
  StationView(boost::asio::io_context& io, SessionHub& hub, MergeWorker& worker, Store& store, StationNotes& notes,
              const MergeConfig& config, const KeepPolicy& keep = {},
              std::function<std::vector<ServerRecord>()> servers = {})
      : io_(io),
        hub_(hub),
        worker_(worker),
        store_(store),
        notes_(notes),
        config_(config),
        keep_(keep),
        servers_(std::move(servers)) {}

  std::vector<SessionRow> sessions() const override;
  AtlasView atlas() const override;
  Pending pending() const override;
  Workload workload() const override;
  LinkHealth link_health() const override;
  std::vector<ServerRecord> servers() const override;
  MergeConfig merge_config() const override { return config_; }
  void when_idle(double timeout_s, std::function<void(Pending)> callback) override;
  void merge_all() override;
  void decide(AlignmentId alignment, Decision decision, std::function<void(const Result<void>&)> callback) override;
  void place(SessionId a, SessionId b, const Pose& T_a_b,
             std::function<void(const Result<HandPlacement>&)> callback) override {
    worker_.place(a, b, T_a_b, std::move(callback));
  }
  void rename(SessionId session, const std::string& label, std::function<void(const Result<void>&)> callback) override;
  void anchor(SessionId session, std::function<void(const Result<void>&)> callback) override;
  void request_clouds(SessionId session, std::function<void(const Result<std::size_t>&)> callback) override;
  void set_aside(SessionId session, const std::string& why, std::function<void(const Result<void>&)> callback) override;
  void release(SessionId session, std::function<void(const Result<void>&)> callback) override;
  void remove(SessionId session, std::function<void(const Result<void>&)> callback) override;
  void set_site(SessionId session, const std::string& site, std::function<void(const Result<void>&)> callback) override;
  void set_robot_site(const std::string& robot, const std::string& site,
                      std::function<void(const Result<void>&)> callback) override;
  std::map<std::string, std::string> robot_sites() const override;
  void archive(SessionId session, bool archived, std::function<void(const Result<void>&)> callback) override;
  void freeze(SessionId session, bool frozen, std::function<void(const Result<void>&)> callback) override;
  void note(SessionId session, const std::string& note, std::function<void(const Result<void>&)> callback) override;
  std::vector<Survey> surveys() const override { return notes_.surveys(); }
  void set_survey(const Survey& survey, std::function<void(const Result<void>&)> callback) override;
  void drop_survey(SessionId session, std::function<void(const Result<void>&)> callback) override;
  Result<std::vector<Keyframe>> trajectory(SessionId session) const override;
  Result<KeyframeCloud> cloud(SessionId session, std::uint64_t sequence) const override;
  Result<std::optional<std::uint64_t>> free_bytes() const override { return store_.free_bytes(); }
  Result<std::vector<CoveredClouds>> covered_clouds() const override;
  KeepPolicy keep_policy() const override { return keep_; }
  void let_go(std::vector<CoveredClouds> clouds, std::function<void(const Result<void>&)> callback) override;
  Result<std::filesystem::path> backup() override { return store_.backup(); }

 private:
  Error damaged(const KeyframeRef& cloud, const Error& why) const;

  boost::asio::io_context& io_;
  SessionHub& hub_;
  MergeWorker& worker_;
  Store& store_;
  StationNotes& notes_;
  const MergeConfig config_;
  const KeepPolicy keep_;
  const std::function<std::vector<ServerRecord>()> servers_;
  mutable std::mutex mutex_;
  mutable std::set<KeyframeRef> damaged_clouds_;
};

}  // namespace headframe
