// What a standby server reads from PostgreSQL is what the active server's pipeline has, to the bit.
#include "server/merge_worker/pair_replica.hpp"

#include <gtest/gtest.h>

#include <future>

#include "common/cloud/cloud_codec.hpp"
#include "server/store/postgres_reader.hpp"
#include "server/store/postgres_store.hpp"
#include "tests/support/pair_searcher.hpp"
#include "tests/support/postgres_fixture.hpp"

namespace headframe::test {
namespace {

class PostgresPairReplica : public PostgresFixture {
 protected:
  void SetUp() override {
    PostgresFixture::SetUp();
    if (!cluster) return;
    drives = {drive_a_to_c(3), drive_b_to_a(3)};
    for (Drive& drive : drives)
      for (KeyframeCloud& cloud : drive.clouds) cloud = decode_points(encode_cloud(cloud).value()).value();
    auto opened = open_postgres_store(scratch.path() / "store", url);
    ASSERT_TRUE(opened) << opened.error().message;
    store = std::move(*opened);
    for (SessionId id = 1; id <= 2; ++id) put(id, drives[static_cast<std::size_t>(id - 1)]);
    there.emplace(stored_drives());
    auto database = std::make_unique<PostgresDatabase>(url, "PostgreSQL");
    ASSERT_TRUE(database->connect());
    reader.emplace(std::move(database));
    replica.emplace(there->config, *reader);
  }

  void write(Write write) {
    std::promise<Result<void>> done;
    store->write(std::move(write), [&](const Result<void>& result) { done.set_value(result); });
    const auto result = done.get_future().get();
    ASSERT_TRUE(result) << result.error().message;
  }

  void put(SessionId id, const Drive& drive) {
    SessionRecord record;
    record.id = id;
    record.key = {"robot " + std::to_string(id), "one"};
    record.sensor = {"drawn", 32, 22.5F, 22.5F, 60};
    record.family = ScanContext().id();
    record.q_size = static_cast<std::uint32_t>(drive.keyframes.front().descriptor.q.size());
    record.w_size = static_cast<std::uint32_t>(drive.keyframes.front().descriptor.w.size());
    write(PutSession{record});
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
      write(PutKeyframe{id, drive.keyframes[i]});
      write(PutCloud{{id, drive.keyframes[i].sequence}, encode_cloud(drive.clouds[i]).value()});
    }
    write(CompleteSession{id});
  }

  /// With the keyframes as they come back from the store.
  std::vector<Drive> stored_drives() {
    std::vector<Drive> out = drives;
    for (SessionId id = 1; id <= 2; ++id) {
      auto& keyframes = out[static_cast<std::size_t>(id - 1)].keyframes;
      keyframes.clear();
      EXPECT_TRUE(store->each_keyframe(id, 1, [&](Keyframe keyframe) { keyframes.push_back(std::move(keyframe)); }));
    }
    return out;
  }

  std::vector<Drive> drives;
  std::unique_ptr<Store> store;
  std::optional<PairSearcher> there;
  std::optional<PostgresReader> reader;
  std::optional<PairReplica> replica;
};

TEST_F(PostgresPairReplica, FindsTheSameAsWhoHasTheSessionsInMemory) {
  for (const auto& [a, b] : {std::pair(1, 2), {2, 1}, {1, 1}}) {
    const auto found = replica->find(there->task(a, b));
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(*found, there->find(a, b)) << a << " and " << b;
  }
}

TEST_F(PostgresPairReplica, AnswersOnlyForWhatIsStored) {
  ASSERT_TRUE(replica->find(there->task(1, 2)));
  there->shelf.clouds.erase({1, 3});
  const auto unlike = replica->find(there->task(1, 2));
  ASSERT_FALSE(unlike);
  EXPECT_EQ(unlike.error().code, ErrorCode::refused);
  write(LetGo{{{1, 3}}});
  const auto alike = replica->find(there->task(1, 2));
  ASSERT_TRUE(alike) << alike.error().message;
  EXPECT_EQ(*alike, there->find(1, 2));
  PairTask of_nobody = there->task(1, 2);
  of_nobody.b = 7;
  EXPECT_FALSE(replica->find(of_nobody));
  of_nobody.digest.clear();
  EXPECT_FALSE(replica->find(of_nobody));
}

TEST_F(PostgresPairReplica, FollowsKeyframesThatMovedAndSessionsThatGrow) {
  ASSERT_TRUE(replica->find(there->task(1, 2)));
  PutMerge moved;
  Pose T = there->sessions.at(2).keyframes[4].T_local_sensor;
  T.translation().x() += 0.01;
  moved.moved = MovedPoses{2, 1, {{5, T}}};
  write(moved);
  PairSearcher now(stored_drives());
  ASSERT_NE(now.digest(1, 2), there->digest(1, 2));
  const auto found = replica->find(now.task(1, 2));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(*found, now.find(1, 2));
}

}  // namespace
}  // namespace headframe::test
