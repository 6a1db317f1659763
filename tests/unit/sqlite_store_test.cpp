// The data directory of SQLite's store.
#include <gtest/gtest.h>

#include <fstream>

#include "server/store/schema.hpp"
#include "server/store/sqlite.hpp"
#include "tests/support/keyframes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

TEST(SqliteStore, NobodyElseReadsWhatIsInIt) {
  namespace fs = std::filesystem;
  const auto mode = [](const fs::path& path) { return fs::status(path).permissions(); };
  constexpr auto folder = fs::perms::owner_all, file = fs::perms::owner_read | fs::perms::owner_write;
  const TempDir dir;
  const fs::path data = dir.path() / "new" / "data", db = data / "headframe.db";
  for (const bool of_an_older_server : {false, true}) {
    if (of_an_older_server) {
      fs::permissions(data, fs::perms(0755));
      fs::permissions(db, fs::perms(0644));
      fs::permissions(data / "headframe.lock", fs::perms(0644));
    }
    const auto store = open_sqlite_store(data);
    ASSERT_TRUE(store);
    ASSERT_TRUE(write_and_wait(**store, PutSession{session_record(1, "ant")}));
    EXPECT_EQ(mode(data), folder);
    for (const char* name : {"headframe.db", "headframe.db-wal", "headframe.db-shm", "headframe.lock"})
      EXPECT_EQ(mode(data / name), file) << name;
  }
}

TEST(SqliteStore, ASecondServerIsKeptOutAlsoWithoutTheLockFile) {
  const TempDir dir;
  const auto first = open(dir);
  ASSERT_TRUE(std::filesystem::remove(dir.path() / "headframe.lock"));
  const auto second = open_sqlite_store(dir.path());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("in use by another"), std::string::npos) << second.error().message;
}

TEST(SqliteStore, AFolderWithOtherThingsInItStaysOpenToOthers) {
  namespace fs = std::filesystem;
  const TempDir home;
  fs::permissions(home.path(), fs::perms(0755));
  std::ofstream(home.path() / "letter.txt") << "dear";
  const auto store = open(home);
  EXPECT_EQ(fs::status(home.path()).permissions(), fs::perms(0755));
  EXPECT_EQ(fs::status(home.path() / "headframe.db").permissions(), fs::perms(0600));
}

std::string open_error(const std::filesystem::path& path) {
  const auto store = open_sqlite_store(path);
  return store ? "opened" : store.error().message;
}

TEST(SqliteStore, BadDirectoriesGiveOneClearLine) {
  const TempDir dir;
  std::ofstream(dir.path() / "file") << "x";
  EXPECT_NE(open_error(dir.path() / "file").find("can not be created"), std::string::npos);
  EXPECT_NE(open_error("/proc/headframe").find("can not be created"), std::string::npos);
  std::filesystem::create_directory(dir.path() / "damaged");
  std::ofstream(dir.path() / "damaged" / "headframe.db") << std::string(100000, 'x');
  EXPECT_NE(open_error(dir.path() / "damaged").find("no headframe database"), std::string::npos);
  EXPECT_EQ(open_error(dir.path() / "made" / "twice"), "opened") << "what is not there is made";
}

TEST(SqliteStore, OneServerToADirectory) {
  const TempDir dir;
  const auto store = open(dir);
  EXPECT_NE(open_error(dir.path()).find("in use"), std::string::npos);
}

TEST(SqliteStore, NewerSchemaIsRefusedAndTheSameIsKept) {
  const TempDir dir;
  open(dir).reset();
  const auto set_version = [&](int version) {
    auto database = SqliteDatabase::open((dir.path() / "headframe.db").string());
    ASSERT_TRUE(database);
    ASSERT_TRUE(database->execute("PRAGMA user_version=" + std::to_string(version)));
  };
  set_version(schema_version() + 1);
  const auto refused = open_sqlite_store(dir.path());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::incompatible);
  EXPECT_NE(refused.error().message.find("newer headframe-server"), std::string::npos);
  set_version(schema_version());
  EXPECT_EQ(open_error(dir.path()), "opened");
}

}  // namespace
}  // namespace headframe
