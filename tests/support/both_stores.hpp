#pragma once
// The same tests over SQLite and PostgreSQL.

#include "server/store/postgres.hpp"
#include "server/store/postgres_store.hpp"
#include "server/store/sqlite.hpp"
#include "tests/support/postgres_cluster.hpp"
#include "tests/support/stores.hpp"

namespace headframe {

enum class Engine { sqlite, postgres };

/// Where a store lives: a folder, and with PostgreSQL a database of its own besides.
class StoreHome {
 public:
  explicit StoreHome(Engine engine) {
    if (engine == Engine::sqlite) return;
    auto* cluster = test::PostgresCluster::of_this_process();
    auto made = cluster != nullptr ? cluster->make_database() : failure(ErrorCode::unavailable, "no PostgreSQL");
    EXPECT_TRUE(made) << made.error().message;
    url_ = made.value_or("postgresql:///none");
  }

  Result<std::unique_ptr<Store>> try_open(const StoreOptions& options = {}) const {
    return url_.empty() ? open_sqlite_store(dir_.path(), options) : open_postgres_store(dir_.path(), url_, options);
  }

  /// The database behind the store's back.
  std::unique_ptr<Database> database() const {
    if (!url_.empty()) {
      auto opened = std::make_unique<PostgresDatabase>(url_, "PostgreSQL");
      EXPECT_TRUE(opened->connect());
      return opened;
    }
    auto opened = SqliteDatabase::open((dir_.path() / "headframe.db").string());
    EXPECT_TRUE(opened);
    return std::make_unique<SqliteDatabase>(std::move(*opened));
  }

  const std::filesystem::path& path() const { return dir_.path(); }
  const std::string& url() const { return url_; }  // empty: SQLite

 private:
  TempDir dir_;
  std::string url_;
};

inline std::unique_ptr<Store> open(const StoreHome& home, const StoreOptions& options = {}) {
  auto store = home.try_open(options);
  EXPECT_TRUE(store) << (store ? "" : store.error().message);
  return store ? std::move(*store) : nullptr;
}

class OverBothStores : public testing::TestWithParam<Engine> {
 protected:
  void SetUp() override {
    if (GetParam() == Engine::postgres && test::PostgresCluster::programs().empty())
      GTEST_SKIP() << test::PostgresCluster::not_installed;
  }
};

// Of a fixture. Those over PostgreSQL run as one test of ctest, so that one cluster serves them all.
#define OVER_BOTH_STORES(fixture)                                             \
  INSTANTIATE_TEST_SUITE_P(Sqlite, fixture, testing::Values(Engine::sqlite)); \
  INSTANTIATE_TEST_SUITE_P(Postgres, fixture, testing::Values(Engine::postgres))

}  // namespace headframe
