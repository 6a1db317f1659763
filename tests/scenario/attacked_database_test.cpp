// Databases in which a server of before, that let them in, kept what broken or hostile robots told: the worker of today
// starts on them, merges the honest sessions beside them, and goes on.

#include <cmath>
#include <future>

#include "common/cloud/cloud_codec.hpp"
#include "server/store/sqlite.hpp"
#include "tests/scenario/drawn_base.hpp"
#include "tests/support/scripted_worker.hpp"

namespace headframe {
namespace {

using test::Drive;

Drive moved(Drive drive, const std::function<void(std::size_t, Eigen::Vector3d&)>& move) {
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
    Eigen::Vector3d p = drive.keyframes[i].T_local_sensor.translation();
    move(i, p);
    drive.keyframes[i].T_local_sensor.translation() = p;
  }
  return drive;
}

Drive first_two(Drive drive) {
  drive.keyframes.resize(2);
  drive.clouds.resize(2);
  return drive;
}

Drive with_cloud(Drive drive, const Points& points) {
  for (KeyframeCloud& cloud : drive.clouds) cloud.sweeps[0].points = points;
  return drive;
}

std::vector<Drive> broken_drives() {
  const Drive sound = test::drive_b_to_a(3);
  const std::size_t middle = sound.keyframes.size() / 2;
  return {
      moved(first_two(sound), [](std::size_t, auto& p) { p += Eigen::Vector3d(5e7, -5e7, 0); }),
      moved(sound, [](std::size_t i, auto& p) { p *= std::pow(-7.0, static_cast<double>(i % 9)); }),
      moved(sound,
            [](std::size_t i, auto& p) { p += 340 * Eigen::Vector3d(i % 2 == 0 ? 0 : 1, i % 4 < 2 ? 0 : 1, 0); }),
      moved(sound, [&](std::size_t i, auto& p) { p.z() += i < middle ? 0 : 12; }),
      with_cloud(sound, Points(30000, Eigen::Vector3f::Zero())),
      with_cloud(first_two(sound), Points(3'900'000, Eigen::Vector3f(3, 1, 0))),
  };
}

/// Says when these sessions are one map.
class Togetherness : public FakeRobots {
 public:
  std::future<void> of(std::set<SessionId> sessions) {
    const std::lock_guard lock(mutex);
    wanted_ = std::move(sessions);
    together_ = {};
    return together_.get_future();
  }
  void publish(const Atlas& atlas, const std::vector<Component>&, const std::vector<Withdrawal>&) override {
    const std::lock_guard lock(mutex);
    for (const Component& component : atlas.components) {
      std::set<SessionId> missing = wanted_;
      for (const Placement& placement : component.placements) missing.erase(placement.session);
      if (wanted_.empty() || !missing.empty()) continue;
      wanted_.clear();
      together_.set_value();
    }
  }

 private:
  std::set<SessionId> wanted_;
  std::promise<void> together_;
};

class AttackedDatabase : public testing::Test {
 protected:
  void keep(SessionId id, const Drive& drive) {
    const Descriptor& any = drive.keyframes.front().descriptor;
    SessionRecord session = session_record(id, "robot" + std::to_string(id));
    session.family = ScanContext().id();
    session.q_size = static_cast<std::uint32_t>(any.q.size());
    session.w_size = static_cast<std::uint32_t>(any.w.size());
    write(PutSession{session});
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
      write(PutKeyframe{id, drive.keyframes[i]});
      write(PutCloud{{id, i + 1}, encode_cloud(drive.clouds[i]).value()});
    }
    write(CompleteSession{id});
  }
  void write(Write what) {
    std::promise<Result<void>> durable;
    store->write(std::move(what), [&](const Result<void>& result) { durable.set_value(result); });
    const Result<void> written = durable.get_future().get();
    ASSERT_TRUE(written) << written.error().message;
  }
  void open_store() { store = std::move(open_sqlite_store(dir.path(), {.group_ms = 0}).value()); }
  void start_worker() {
    worker = std::make_unique<MergeWorker>(make_pipeline(test::waits_for_no_others()), *store, ScheduleConfig());
    ASSERT_TRUE(worker->restore());
    worker->start(robots);
  }
  void stop() {
    worker.reset();
    store.reset();
  }

  TempDir dir;
  Togetherness robots;
  std::unique_ptr<Store> store;
  std::unique_ptr<MergeWorker> worker;
};

TEST_F(AttackedDatabase, StartsAndGoesOn) {
  constexpr auto patience = std::chrono::seconds(240);
  open_store();
  keep(1, test::drive_a_to_c(3));
  SessionId next = 2;
  for (const Drive& drive : broken_drives()) keep(next++, drive);
  keep(next, test::drive_b_to_a(3));
  stop();
  ASSERT_TRUE(SqliteDatabase::open((dir.path() / "headframe.db").string())
                  ->execute("UPDATE keyframes SET checksum = NULL"));  // servers of before had none

  open_store();
  auto honest_two = robots.of({1, next});
  start_worker();
  ASSERT_EQ(honest_two.wait_for(patience), std::future_status::ready);
  EXPECT_EQ(store->load().damaged_keyframes, 0U);
  stop();

  open_store();
  const SessionId newcomer = next + 1;
  keep(newcomer, test::drive_d_to_b(3));
  auto all_three = robots.of({1, next, newcomer});
  start_worker();
  EXPECT_EQ(all_three.wait_for(patience), std::future_status::ready);
  for (const auto& [id, session] : worker->view()->sessions) EXPECT_EQ(session.why_aside, "") << id;
}

}  // namespace
}  // namespace headframe
