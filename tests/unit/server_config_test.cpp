#include <gtest/gtest.h>

#include "server/config/server_config.hpp"

namespace headframe {
namespace {

std::string error_of(std::string_view text) {
  const auto config = parse_config(text, "hf.toml");
  return config ? "accepted" : config.error().message;
}

TEST(ServerConfig, WhatIsNotSetKeepsItsDefault) {
  const auto config = parse_config("[merge]\ntravelled_m = 25\nthreads = 4\n[limits]\nsilence_s = 2.5\n", "hf.toml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->schedule.travelled_m, 25);
  EXPECT_EQ(config->merge.threads, 4);
  EXPECT_EQ(config->limits.silence_s, 2.5);
  EXPECT_EQ(config->limits.robots, RobotLimits{}.robots);
  EXPECT_TRUE(parse_config("", "hf.toml"));
}

TEST(ServerConfig, UnknownKeysAreNamedWithFileLineAndTheKnownOnes) {
  EXPECT_EQ(error_of("[server]\n\nio_treads = 3\n"),
            "hf.toml:3: unknown key 'io_treads' in [server]; its keys are io_threads, name, public");
  EXPECT_NE(error_of("[mrege]\nthreads = 1\n").find("hf.toml:1: unknown section or key 'mrege'"), std::string::npos);
  EXPECT_NE(error_of("threads = 1\n").find("unknown section or key 'threads'"), std::string::npos);
  EXPECT_NE(error_of("server = 1\n").find("unknown section or key 'server'"), std::string::npos);
}

TEST(ServerConfig, TheAddressWhereRobotsComeIsOneThatTheyCanConnectTo) {
  EXPECT_FALSE(parse_config("", "hf.toml")->public_address);
  for (const std::string good : {"mine.example:7447", "10.0.0.7:1", "[2001:db8::7]:7447"}) {
    const auto config = parse_config("[server]\npublic = '" + good + "'\n", "hf.toml");
    ASSERT_TRUE(config) << config.error().message;
    EXPECT_EQ(to_string(config->public_address.value()), good);
  }
  for (const std::string bad : {"'mine.example'", "'mine.example:0'", "'0.0.0.0:7447'", "'[::]:7447'", "''", "7447"})
    EXPECT_EQ(error_of("[server]\npublic = " + bad + "\n"),
              "hf.toml:2: public must be \"HOST:PORT\", the address at which robots reach this server");
}

TEST(ServerConfig, ValuesAreCheckedAtTheirBounds) {
  EXPECT_EQ(error_of("[merge]\naccept_probability = 1\n"), "accepted");
  EXPECT_EQ(error_of("[merge]\naccept_probability = 1.01\n"),
            "hf.toml:2: accept_probability must be a number from 0 to 1");
  EXPECT_EQ(error_of("[merge]\nthreads = 1\n"), "accepted");
  for (const std::string bad : {"0", "1.5", "'many'", "[1]", "nan"})
    EXPECT_EQ(error_of("[merge]\nthreads = " + bad), "hf.toml:2: threads must be a whole number from 1 to 256");
  EXPECT_NE(error_of("[merge]\ntravelled_m = nan\n"), "accepted");
}

TEST(ServerConfig, TheRegistrationEngineIsChosenByName) {
  EXPECT_EQ(parse_config("[merge]\nregistration = 'pcl_gicp'\n", "hf.toml")->merge.registration,
            RegistrationEngine::pcl_gicp);
  EXPECT_EQ(parse_config("", "hf.toml")->merge.registration, RegistrationEngine::vgicp);
  for (const std::string bad : {"'icp'", "1", "''"})
    EXPECT_EQ(error_of("[merge]\nregistration = " + bad), "hf.toml:2: registration must be \"vgicp\" or \"pcl_gicp\"");
}

TEST(ServerConfig, OperatorsAreServedOverTlsBeyondTheLoopbackUnlessItSaysOtherwise) {
  EXPECT_EQ(parse_config("", "hf.toml")->operators.tls, OperatorTls::beyond_loopback);
  EXPECT_EQ(parse_config("[operator]\ntls = 'always'\n", "hf.toml")->operators.tls, OperatorTls::always);
  EXPECT_EQ(parse_config("[operator]\ntls = 'never'\n", "hf.toml")->operators.tls, OperatorTls::never);
  const auto given = parse_config("[operator]\ncertificate = 'c.pem'\nkey = 'k.pem'\n", "hf.toml");
  EXPECT_EQ(given->operators.certificate, "c.pem");
  EXPECT_EQ(given->operators.key, "k.pem");
  for (const std::string bad : {"true", "'yes'", "''"})
    EXPECT_EQ(error_of("[operator]\ntls = " + bad),
              "hf.toml:2: tls must be \"beyond_loopback\", \"always\" or \"never\"");
  EXPECT_EQ(error_of("[operator]\nkey = ''\n"), "hf.toml:2: key must be the name of a PEM file");
  EXPECT_NE(error_of("[operator]\nkey = 'k.pem'\n").find("a key but no certificate"), std::string::npos);
  EXPECT_NE(error_of("[operator]\ntls = 'never'\ncertificate = 'c.pem'\n").find("does not use it"), std::string::npos);
  EXPECT_NE(error_of("[operator]\ntsl = 'never'\n").find("its keys are tls, certificate, key"), std::string::npos);
}

TEST(ServerConfig, TheStoreIsPostgresqlWhereItsUrlIsGiven) {
  EXPECT_EQ(parse_config("[store]\nurl = 'postgresql://mine@db/mine'\n", "hf.toml")->store_url,
            "postgresql://mine@db/mine");
  EXPECT_EQ(parse_config("", "hf.toml")->store_url, "");
  for (const std::string bad : {"'mysql://db/mine'", "'postgresql:/db'", "''", "5432"})
    EXPECT_EQ(
        error_of("[store]\nurl = " + bad),
        "hf.toml:2: url must begin with postgresql://; without url the server keeps an SQLite database in --data");
  EXPECT_NE(error_of("[store]\nurl = 'postgresql://db/mine'\n[limits]\ndatabase_mib = 5").find("database_mib"),
            std::string::npos);
}

TEST(ServerConfig, AServerStandsByOverPostgresqlAlone) {
  EXPECT_FALSE(parse_config("", "hf.toml")->standby);
  EXPECT_TRUE(parse_config("", "hf.toml")->helps);
  EXPECT_FALSE(parse_config("[store]\nhelps = false", "hf.toml")->helps);
  const auto config = parse_config(
      "[server]\nname = 'north shaft'\n[store]\nurl = 'postgresql://db/mine'\nstandby = true\n", "hf.toml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_TRUE(config->standby);
  EXPECT_EQ(config->name, "north shaft");
  EXPECT_NE(error_of("[store]\nstandby = true").find("needs PostgreSQL"), std::string::npos);
  EXPECT_EQ(error_of("[store]\nstandby = false"), "accepted");
  for (const std::string bad : {"1", "'true'", "[]"})
    EXPECT_EQ(error_of("[store]\nstandby = " + bad), "hf.toml:2: standby must be true or false");
  for (const std::string& bad : {std::string("''"), std::string("7"), "'" + std::string(257, 'x') + "'"})
    EXPECT_EQ(error_of("[server]\nname = " + bad), "hf.toml:2: name must be text of 1 to 256 bytes");
}

TEST(ServerConfig, WhatIsKeptWhenRoomIsShort) {
  EXPECT_EQ(parse_config("", "hf.toml")->keep, KeepClouds::all);
  const auto newest = parse_config("[store]\nkeep = 'newest'\nfree_mib = 500", "hf.toml");
  ASSERT_TRUE(newest) << newest.error().message;
  EXPECT_EQ(newest->keep, KeepClouds::newest);
  EXPECT_EQ(newest->free_mib, 500);
  for (const std::string bad : {"'oldest'", "1", "''"})
    EXPECT_EQ(error_of("[store]\nkeep = " + bad), "hf.toml:2: keep must be \"all\" or \"newest\"");
  EXPECT_NE(error_of("[store]\nfree_mib = 0").find("from 1 to"), std::string::npos);
  EXPECT_NE(error_of("[store]\nclouds_mib = 5000").find("is for PostgreSQL only"), std::string::npos);
  const std::string postgres = "[store]\nurl = 'postgresql://db/mine'\nkeep = 'newest'\n";
  EXPECT_NE(error_of(postgres).find("set clouds_mib"), std::string::npos);
  EXPECT_NE(error_of(postgres + "clouds_mib = 1024").find("must be larger than free_mib"), std::string::npos);
  EXPECT_TRUE(parse_config(postgres + "clouds_mib = 1025", "hf.toml"));
}

TEST(ServerConfig, BrokenTomlSaysWhere) {
  EXPECT_EQ(error_of("[merge]\nthreads = = 2\n").rfind("hf.toml:2: ", 0), 0U);
  const auto missing = load_config("/nowhere/hf.toml");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace headframe
