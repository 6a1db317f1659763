#include "server/store/backup.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>

#include "common/security/private_file.hpp"
#include "server/store/schema.hpp"
#include "server/store/sqlite.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

struct Backup : testing::Test {
  void SetUp() override {
    fs::create_directories(data());
    ASSERT_TRUE(write_private_file(data() / "identity.pem", "a key"));
    ASSERT_TRUE(write_private_file(data() / "operator.token", "a token"));
    open_store();
    ASSERT_TRUE(write_and_wait(*store, PutSession{session_record(1, "ant")}));
    put_keyframe(1);
    ASSERT_TRUE(write_and_wait(*store, PutCloud{{1, 1}, "a cloud"}));
  }

  fs::path data() const { return dir.path() / "data"; }
  fs::path file() const { return dir.path() / "backup.db"; }
  fs::path restored() const { return dir.path() / "restored"; }
  void open_store() {
    auto opened = open_sqlite_store(data());
    ASSERT_TRUE(opened) << opened.error().message;
    store = std::move(*opened);
  }
  void put_keyframe(std::uint64_t sequence) {
    ASSERT_TRUE(write_and_wait(*store, PutKeyframe{1, line_keyframe(sequence)}));
  }
  void expect_refused(ErrorCode code, const std::string& says) {
    const auto done = restore_backup(file(), restored());
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, code) << done.error().message;
    EXPECT_NE(done.error().message.find(says), std::string::npos) << done.error().message;
    EXPECT_EQ(done.error().message.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(restored() / "headframe.db"));
    EXPECT_FALSE(fs::exists(restored() / "identity.pem"));
  }

  TempDir dir;
  std::unique_ptr<Store> store;
};

TEST_F(Backup, HoldsAllThatIsDurableAndWhatRobotsKnowTheServerBy) {
  ASSERT_TRUE(write_backup(data(), file()));
  EXPECT_EQ(fs::status(file()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  put_keyframe(2);
  ASSERT_TRUE(restore_backup(file(), restored()));
  EXPECT_EQ(read_private_file(restored() / "identity.pem").value(), "a key");
  EXPECT_EQ(read_private_file(restored() / "operator.token").value(), "a token");
  const auto old = open_sqlite_store(restored());
  ASSERT_TRUE(old) << old.error().message;
  EXPECT_EQ((*old)->sessions()->at(0).key.robot, "ant");
  EXPECT_EQ((*old)->last_keyframe(1).value(), 1U) << "as it was when the backup was made";
  EXPECT_EQ((*old)->cloud({1, 1}).value(), "a cloud");
  EXPECT_TRUE(write_and_wait(**old, PutKeyframe{1, line_keyframe(2)})) << "and it is written to";
}

TEST_F(Backup, ThatIsMadeWhileRobotsSendHasNoHolesAndNothingHalf) {
  std::atomic<bool> enough = false;
  std::thread robot([&] {
    for (std::uint64_t i = 2; !enough; ++i) {
      store->write(PutKeyframe{1, line_keyframe(i)}, [](const Result<void>&) {});
      (void)write_and_wait(*store, PutCloud{{1, i}, "cloud " + std::to_string(i)});
    }
  });
  std::uint64_t before = 0;
  for (int i = 0; i < 5; ++i) {
    const auto made = store->backup();
    ASSERT_TRUE(made) << made.error().message;
    const fs::path where = restored() / std::to_string(i);
    ASSERT_TRUE(restore_backup(*made, where));
    const auto old = open_sqlite_store(where);
    ASSERT_TRUE(old);
    const auto all = keyframes(**old, 1);
    ASSERT_GE(all.size(), std::max<std::uint64_t>(before, 1));
    before = all.size();
    for (std::size_t k = 0; k < all.size(); ++k) EXPECT_EQ(all[k].sequence, k + 1);
    const auto clouds = (*old)->cloud_sequences(1);
    for (const std::uint64_t sequence : *clouds) EXPECT_LE(sequence, all.size());
  }
  enough = true;
  robot.join();
}

TEST_F(Backup, ReplacesNoDatabase) {
  ASSERT_TRUE(write_backup(data(), file()));
  const auto done = restore_backup(file(), data());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::refused);
  EXPECT_EQ(store->cloud({1, 1}).value(), "a cloud");
}

TEST_F(Backup, OfNothingAndOfWhatIsNoneIsRefused) {
  expect_refused(ErrorCode::not_found, "no file");
  EXPECT_EQ(write_backup(restored(), file()).error().code, ErrorCode::not_found);
  EXPECT_FALSE(fs::exists(file()));
  std::ofstream(file()) << "a letter";
  expect_refused(ErrorCode::bad_input, "no whole backup");
  fs::remove(file());
  std::ofstream(file()).flush();
  expect_refused(ErrorCode::bad_input, "no whole backup");
  fs::copy_file(data() / "headframe.db", file(), fs::copy_options::overwrite_existing);
  expect_refused(ErrorCode::bad_input, "no whole backup");  // a database that lacks its log
}

TEST_F(Backup, CutShortAnywhereIsRefused) {
  ASSERT_TRUE(write_backup(data(), file()));
  const auto whole = fs::file_size(file());
  for (const double share : {0.999, 0.9, 0.5, 0.1}) {
    fs::resize_file(file(), static_cast<std::uintmax_t>(share * static_cast<double>(whole)));
    expect_refused(ErrorCode::bad_input, "no whole backup");
    fs::remove(file());
    ASSERT_TRUE(write_backup(data(), file()));
  }
}

TEST_F(Backup, OfANewerServerAndOneThatHoldsOtherFilesAreRefused) {
  ASSERT_TRUE(write_backup(data(), file()));
  {
    auto database = SqliteDatabase::open(file().string());
    ASSERT_TRUE(database->execute("PRAGMA user_version=" + std::to_string(schema_version() + 1)));
  }
  expect_refused(ErrorCode::incompatible, "newer");
  ASSERT_TRUE(write_backup(data(), file()));
  {
    auto database = SqliteDatabase::open(file().string());
    ASSERT_TRUE(database->execute("INSERT INTO private_files VALUES ('../escaped', x'00')"));
  }
  expect_refused(ErrorCode::bad_input, "no whole backup");
  EXPECT_FALSE(fs::exists(dir.path() / "escaped"));
}

TEST_F(Backup, ThatCouldNotBeWrittenLeavesNothing) {
  EXPECT_FALSE(write_backup(data(), dir.path() / "nowhere" / "backup.db"));
  fs::create_directory(file());
  EXPECT_FALSE(write_backup(data(), file()));
  EXPECT_FALSE(fs::exists(file().string() + ".part"));
}

TEST_F(Backup, UnfinishedOnesAreRemovedAtTheNextStart) {
  std::ofstream(data() / "headframe.backup-3.part") << "half";
  std::ofstream(data() / "headframe.backup-2") << "whole, not sent";
  store.reset();
  open_store();
  EXPECT_FALSE(fs::exists(data() / "headframe.backup-3.part"));
  EXPECT_FALSE(fs::exists(data() / "headframe.backup-2"));
}

}  // namespace
}  // namespace headframe
