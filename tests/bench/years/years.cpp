#include "tests/bench/years/years.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>

#include "common/cloud/cloud_codec.hpp"
#include "common/descriptor/family.hpp"
#include "server/merge_worker/merge_worker.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/years/drawn_years.hpp"

namespace headframe::bench {
namespace {

using Clock = std::chrono::steady_clock;

double s_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double resident_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Keeps the worker from its news, so that it sees an upload and its end at once.
class Stopped {
 public:
  explicit Stopped(MergeWorker& worker) {
    std::promise<void> here;
    constexpr SessionId nobody = -1;
    worker.anchor(nobody, [&here, go = go_.get_future().share()](const Result<void>&) {
      here.set_value();
      go.wait();
    });
    here.get_future().wait();
  }
  void go_on() const { go_.set_value(); }

 private:
  mutable std::promise<void> go_;
};

/// Nobody is there; remembers when a session was first told that it is merged.
class NoRobots : public Robots {
 public:
  void request_submap(SessionId, const std::vector<std::uint64_t>&) override {}
  void publish(const Atlas& atlas, const std::vector<Component>&, const std::vector<Withdrawal>&) override {
    const auto now = Clock::now();
    const std::lock_guard lock(mutex_);
    for (const Component& component : atlas.components)
      if (component.placements.size() > 1)
        for (const Placement& placement : component.placements) merged_at_.try_emplace(placement.session, now);
  }
  void tell_provisional(const Atlas&, const std::vector<Component>&) override {}
  void tell_localization(SessionId, const SessionLocalization&) override {}
  void tell_cut(SessionId, const SessionCut&) override {}

  std::optional<Clock::time_point> merged_at(SessionId session) const {
    const std::lock_guard lock(mutex_);
    const auto found = merged_at_.find(session);
    return found == merged_at_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  mutable std::mutex mutex_;
  std::map<SessionId, Clock::time_point> merged_at_;
};

/// A database that grows over the run, and is found again by the next.
class Years {
 public:
  Years(const YearsBench& bench, const std::filesystem::path& data) : bench_(bench) {
    StoreOptions options;
    options.queue_bytes = 1UL << 30U;
    auto opened = open_sqlite_store(data, options);
    if (!opened) throw std::runtime_error(opened.error().message);
    store_ = std::move(*opened);
    const auto sessions = store_->sessions();
    if (!sessions) throw std::runtime_error(sessions.error().message);
    stored_ = sessions->size();
  }

  std::size_t stored() const { return stored_; }

  /// Draws sessions until so many are stored. They count as tried.
  void fill(std::size_t count) {
    for (; stored_ < count; ++stored_) {
      const auto id = static_cast<SessionId>(stored_) + 1;
      const test::Drive drive = drawn_drive(static_cast<std::uint64_t>(id), bench_.keyframes);
      put(id, drive);
      PutMerge tried{id, drive.keyframes.size(), {}, std::nullopt, {}};
      tried.attempted_whole = true;
      tried.self_likeness[id] = {path_m(drive) + 1e-6, drive.clouds.size(), 0, 0, 0, {}, {}};
      write(std::move(tried));
      std::fprintf(stderr, "\rdrawn %zu of %zu sessions ", stored_ + 1, count);
    }
    std::fprintf(stderr, "\n");
  }

  struct Figures {
    double restart_s = 0, rss_mb = 0, answer_s = 0;
    std::vector<double> merge_s, settle_s, settle_cpu_s;  // merge_s: of those that merged
    int right = 0, wrong = 0;
    nlohmann::json json() const {
      return {{"restart_s", restart_s},
              {"rss_mb", rss_mb},
              {"merge_p50_s", quantile(merge_s, 0.5)},
              {"merge_p95_s", quantile(merge_s, 0.95)},
              {"settle_p50_s", quantile(settle_s, 0.5)},
              {"settle_p95_s", quantile(settle_s, 0.95)},
              {"settle_cpu_p50_s", quantile(settle_cpu_s, 0.5)},
              {"merged_rightly", right},
              {"merged_wrongly", wrong}};
    }
  };

  /// Starts a worker on what is stored; visitors come one after another. They stay in this worker alone.
  Figures visit(std::size_t count) {
    Figures out;
    const auto start = Clock::now();
    NoRobots robots;
    MergeWorker worker(make_pipeline({}), *store_, {.submap_s = 0.1});
    if (auto ok = worker.restore(); !ok) throw std::runtime_error(ok.error().message);
    out.answer_s = s_since(start);
    worker.start(robots);
    settle(worker);
    out.restart_s = s_since(start);
    out.rss_mb = resident_mb();
    for (std::size_t i = 0; i < bench_.visits; ++i) {
      const std::size_t host = (2 * i + 1) * count / (2 * bench_.visits) + 1;
      const test::Drive first = drawn_drive(host, bench_.keyframes), second = drawn_visit(host, bench_.keyframes);
      const SessionId id = static_cast<SessionId>(++stored_);
      put(id, second);
      const Stopped stopped(worker);
      worker.session_added(id, {"visitor", family()});
      worker.keyframes_durable(id, second.keyframes.size());
      for (const Keyframe& k : second.keyframes) worker.cloud_durable({id, k.sequence});
      worker.trigger(id, Trigger::goodbye);
      const auto uploaded = Clock::now();
      const double cpu_before_s = cpu_s();
      stopped.go_on();
      settle(worker);
      out.settle_s.push_back(s_since(uploaded));
      if (const auto merged = robots.merged_at(id))
        out.merge_s.push_back(std::chrono::duration<double>(*merged - uploaded).count());
      out.settle_cpu_s.push_back(cpu_s() - cpu_before_s);
      judge(*worker.view(), static_cast<SessionId>(host), id, first.T_mine_local.inverse() * second.T_mine_local, out);
    }
    worker.stop();
    return out;
  }

 private:
  static FamilyId family() {
    static const FamilyId id = make_family(default_family_name).value()->id();
    return id;
  }

  static double path_m(const test::Drive& drive) {
    double out = 0;
    for (std::size_t i = 1; i < drive.keyframes.size(); ++i)
      out += (position(drive.keyframes[i]) - position(drive.keyframes[i - 1])).norm();
    return out;
  }

  /// Polls: what is measured takes seconds.
  static void settle(const MergeWorker& worker) {
    while (!worker.pending().idle()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }

  void write(Write write) {
    std::promise<Result<void>> done;
    store_->write(std::move(write), [&](const Result<void>& result) { done.set_value(result); });
    if (auto result = done.get_future().get(); !result) throw std::runtime_error(result.error().message);
  }

  void put(SessionId id, const test::Drive& drive) {
    SessionRecord record;
    record.id = id;
    record.key = {"robot " + std::to_string(id), "one"};
    record.sensor = {"drawn", 32, 22.5F, 22.5F, 60};
    record.family = family();
    record.q_size = static_cast<std::uint32_t>(drive.keyframes.front().descriptor.q.size());
    record.w_size = static_cast<std::uint32_t>(drive.keyframes.front().descriptor.w.size());
    const auto later = [](const Result<void>&) {};
    store_->write(PutSession{record}, later);
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
      store_->write(PutKeyframe{id, drive.keyframes[i]}, later);
      store_->write(PutCloud{{id, drive.keyframes[i].sequence}, encode_cloud(drive.clouds[i]).value()}, later);
    }
    write(CompleteSession{id});
  }

  static void judge(const MergeView& view, SessionId host, SessionId visitor, const Pose& T_true, Figures& out) {
    for (const Alignment& k : view.alignments) {
      if (k.b != visitor || k.state != AlignmentState::published) continue;
      const Pose error = T_true.inverse() * k.T_a_b;
      const bool right = k.a == host && error.translation().norm() < 1 && rotation_angle_rad(error) < 0.05;
      ++(right ? out.right : out.wrong);
    }
  }

  const YearsBench& bench_;
  std::unique_ptr<Store> store_;
  std::size_t stored_ = 0;
};

}  // namespace

nlohmann::json years(const YearsBench& bench) {
  for (const std::size_t count : bench.stored)
    if (count < bench.visits)  // two visitors of one mine would be merged, too
      throw std::runtime_error(std::to_string(count) + " stored sessions are too few for " +
                               std::to_string(bench.visits) + " visits, each to another one: raise --stored");
  nlohmann::json out;
  std::vector<double> settle_cpu_s;
  spdlog::set_level(spdlog::level::warn);
  std::printf("years: sessions of %zu keyframes, each in a mine of its own; then %zu visits, one after another\n",
              bench.keyframes, bench.visits);
  std::printf(
      "  stored   start s   answers s   memory MB   merged p50 s   p95 s   settled p50 s   p95 s   cpu p50 s   "
      "merged rightly   wrongly\n");
  for (const std::size_t count : bench.stored) {
    const auto kept = bench.out / "years" / std::to_string(bench.keyframes) / std::to_string(count);
    const auto data = bench.out / "years" / "now";
    std::filesystem::create_directories(kept);
    Years(bench, kept).fill(count);
    std::filesystem::remove_all(data);
    std::filesystem::copy(kept, data, std::filesystem::copy_options::recursive);
    const auto figures = Years(bench, data).visit(count);
    std::printf("  %6zu   %7.1f   %9.2f   %9.0f   %12.2f   %5.2f   %13.2f   %5.2f   %9.2f   %9d of %zu   %7d\n", count,
                figures.restart_s, figures.answer_s, figures.rss_mb, quantile(figures.merge_s, 0.5),
                quantile(figures.merge_s, 0.95), quantile(figures.settle_s, 0.5), quantile(figures.settle_s, 0.95),
                quantile(figures.settle_cpu_s, 0.5), figures.right, bench.visits, figures.wrong);
    std::fflush(stdout);
    out["by_sessions"][std::to_string(count)] = figures.json();
    out["settle_p95_s"] = quantile(figures.settle_s, 0.95);
    out["restart_s"] = figures.restart_s;
    out["rss_mb"] = figures.rss_mb;
    settle_cpu_s.push_back(quantile(figures.settle_cpu_s, 0.5));
  }
  if (const std::size_t n = settle_cpu_s.size(); n > 1)
    out["settle_cpu_ratio_last_two"] = settle_cpu_s[n - 1] / settle_cpu_s[n - 2];
  const nlohmann::json& by = out["by_sessions"];
  if (by.contains("100") && by.contains("1000"))
    out["settle_ratio_1000_100"] = by["1000"]["settle_p50_s"].get<double>() / by["100"]["settle_p50_s"].get<double>();
  return out;
}

}  // namespace headframe::bench
