#pragma once
// Tests that each have a PostgreSQL of their own, with an empty database in it; skipped where it is not installed.

#include <gtest/gtest.h>

#include "tests/support/base_station.hpp"
#include "tests/support/postgres_cluster.hpp"

namespace headframe::test {

class PostgresFixture : public testing::Test {
 protected:
  void SetUp() override {
    if (PostgresCluster::programs().empty()) GTEST_SKIP() << PostgresCluster::not_installed;
    auto made = PostgresCluster::make();
    ASSERT_TRUE(made) << made.error().message;
    cluster = std::move(*made);
    const auto database = cluster->make_database();
    ASSERT_TRUE(database) << database.error().message;
    url = *database;
  }

  ScratchFolder scratch;
  std::unique_ptr<PostgresCluster> cluster;
  std::string url;  // of the database
};

}  // namespace headframe::test
