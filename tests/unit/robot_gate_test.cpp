// The gate with a real store and a manual clock.
#include "server/security/robot_gate.hpp"

#include <gtest/gtest.h>

#include <future>

#include "common/security/secret.hpp"
#include "server/store/sqlite_store.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::make_address;

struct Gate : testing::Test {
  void SetUp() override { reopen(); }
  void reopen() {
    gate.reset();
    store.reset();
    store = open_sqlite_store(dir.path()).value();
    RobotGate::Seams seams{
        [this] { return now_s; },
        [this](const std::string& robot, const std::string& why) { ended += robot + " " + why + "\n"; },
        [this](const std::string& robot, std::uint64_t kib_s) { rates[robot] = kib_s; }, [this] { return steady_s; }};
    gate =
        std::make_unique<RobotGate>(*store, seams, AttemptLimits{.failures = 2, .forgiven_per_s = 1, .addresses = 9});
    ASSERT_TRUE(gate->restore());
  }
  std::string open(const std::string& robot) {
    std::promise<std::string> code;
    gate->open(robot, [&](const Result<std::string>& opened) { code.set_value(opened.value()); });
    return code.get_future().get();
  }
  Result<void> admit(const std::string& robot, const Credential& shown, const std::string& from = "10.0.0.1") {
    std::promise<Result<void>> done;
    gate->admit(robot, shown, make_address(from), now, [&](const Result<void>& r) { done.set_value(r); });
    return done.get_future().get();
  }
  Result<void> revoke(const std::string& robot) {
    std::promise<Result<void>> done;
    gate->revoke(robot, [&](const Result<void>& r) { done.set_value(r); });
    return done.get_future().get();
  }

  Result<void> set_rate(const std::string& robot, std::uint64_t kib_s) {
    std::promise<Result<void>> done;
    gate->set_rate(robot, kib_s, [&](const Result<void>& r) { done.set_value(r); });
    return done.get_future().get();
  }

  TempDir dir;
  double now_s = 1000, steady_s = 7;
  AttemptLimiter::Time now{};
  std::string ended;
  std::map<std::string, std::uint64_t> rates;
  std::unique_ptr<Store> store;
  std::unique_ptr<RobotGate> gate;
  const std::string token = random_secret(token_bytes), other = random_secret(token_bytes);
};

TEST_F(Gate, WhatItSaidYesToOutlivesTheServer) {
  const std::string code = open("ant");
  reopen();
  EXPECT_TRUE(admit("ant", {token, code}));
  reopen();
  EXPECT_TRUE(admit("ant", {token, ""}));
  EXPECT_FALSE(admit("ant", {other, code})) << "used, also after a restart";
  EXPECT_TRUE(revoke("ant"));
  reopen();
  EXPECT_FALSE(admit("ant", {token, ""}));
}

TEST_F(Gate, ARevocationIsKeptWhileTheDiskIsFull) {
  ASSERT_TRUE(admit("ant", {token, open("ant")}));
  ASSERT_TRUE(admit("bee", {other, open("bee")}));
  auto revocations = RevocationLog::open(dir.path() / "revoked");
  ASSERT_TRUE(revocations);
  const auto start_anew = [&](std::size_t queue_bytes) {
    gate.reset();
    store.reset();
    store = open_sqlite_store(dir.path(), {.queue_bytes = queue_bytes}).value();
    gate = std::make_unique<RobotGate>(*store, RobotGate::Seams{[this] { return now_s; }, {}, {}}, AttemptLimits{},
                                       &*revocations);
    ASSERT_TRUE(gate->restore());
  };
  start_anew(1);  // every write is one too many
  EXPECT_TRUE(revoke("ant"));
  EXPECT_FALSE(admit("ant", {token, ""}));
  ASSERT_EQ(revocations->waiting().size(), 1U);
  start_anew(1);
  EXPECT_FALSE(admit("ant", {token, ""})) << "the server went down before there was room";
  EXPECT_TRUE(admit("bee", {other, ""}));
  start_anew(1 << 20);
  EXPECT_FALSE(admit("ant", {token, ""}));
  gate.reset();
  store.reset();  // all is written
  EXPECT_TRUE(revocations->waiting().empty());
  start_anew(1 << 20);
  EXPECT_FALSE(admit("ant", {token, ""}));
  EXPECT_TRUE(admit("ant", {token, open("ant")})) << "who is invited again comes in";
  start_anew(1 << 20);
  EXPECT_TRUE(admit("ant", {token, ""}));
}

TEST_F(Gate, TheListOfRevocationsIsOfOneSizeAndSaysWhenItIsFull) {
  const auto path = dir.path() / "revoked";
  {
    auto log = RevocationLog::open(path);
    ASSERT_TRUE(log);
    const auto bytes = std::filesystem::file_size(path);
    for (std::size_t i = 0; i < RevocationLog::slots; ++i)
      ASSERT_TRUE(log->add({std::string(128, 'x'), std::string(32, '\xff')}));
    EXPECT_EQ(log->add({"one more", ""}).error().code, ErrorCode::unavailable);
    log->remove(7);
    EXPECT_EQ(log->add({"one more", ""}), 7U);
    EXPECT_EQ(std::filesystem::file_size(path), bytes) << "a full disk has these blocks already";
  }
  const auto waiting = RevocationLog::open(path)->waiting();
  ASSERT_EQ(waiting.size(), RevocationLog::slots);
  EXPECT_EQ(waiting[7].entry.robot, "one more");
  EXPECT_EQ(waiting[8].entry.robot, std::string(128, 'x'));
  EXPECT_EQ(waiting[8].entry.token_digest, std::string(32, '\xff'));
}

TEST_F(Gate, AClockThatIsSetBackRevivesNoCode) {
  const auto refusal = [&](const std::string& code) {
    now += 10s;  // each is looked at
    const auto admitted = admit("ant", {token, code});
    return admitted ? "let in" : admitted.error().message;
  };
  std::string code = open("ant");
  now_s += RobotRegistry::code_lifetime_s;
  EXPECT_NE(refusal(code).find("expired"), std::string::npos);
  now_s -= 100;
  EXPECT_NE(refusal(code).find("expired"), std::string::npos) << "it was seen to be over";
  code = open("ant");
  now_s -= 1800;
  steady_s += RobotRegistry::code_lifetime_s;
  EXPECT_NE(refusal(code).find("expired"), std::string::npos) << "nobody looked, an hour passed all the same";
  now_s += 1e6;
  const std::string late = open("ant");
  now_s = 1000;
  reopen();
  steady_s += RobotRegistry::code_lifetime_s + 1;
  EXPECT_NE(refusal(late).find("expired"), std::string::npos) << "a restart gives no time back";
}

TEST_F(Gate, AClockThatIsSetBackMakesNoCodeLastLongerOrShorter) {
  const std::string code = open("ant");
  now_s = 0;
  steady_s += RobotRegistry::code_lifetime_s - 1;
  EXPECT_TRUE(admit("ant", {token, code}));
}

TEST_F(Gate, ConnectionsEndWithTheirCredential) {
  EXPECT_TRUE(admit("ant", {token, open("ant")}));
  EXPECT_EQ(ended, "ant it has enrolled anew\n") << "there is none the first time, and nobody minds";
  ended.clear();
  EXPECT_TRUE(admit("ant", {token, ""}));
  EXPECT_EQ(ended, "");
  EXPECT_TRUE(admit("ant", {other, open("ant")}));
  EXPECT_EQ(ended, "ant it has enrolled anew\n");
  EXPECT_FALSE(gate->holds("ant", token));
  ended.clear();
  EXPECT_TRUE(revoke("ant"));
  EXPECT_EQ(ended, "ant it was revoked\n");
  EXPECT_EQ(revoke("bee").error().code, ErrorCode::not_found);
}

TEST_F(Gate, ARateOutlivesTheServerAndTheCredential) {
  EXPECT_EQ(set_rate("ant", 5).error().code, ErrorCode::not_found);
  EXPECT_TRUE(admit("ant", {token, open("ant")}));
  EXPECT_TRUE(set_rate("ant", RobotRegistry::most_rate_kib_s));
  EXPECT_EQ(set_rate("ant", RobotRegistry::most_rate_kib_s + 1).error().code, ErrorCode::invalid_argument);
  EXPECT_TRUE(set_rate("ant", 64));
  EXPECT_EQ(rates["ant"], 64U) << "told when it is durable";
  EXPECT_TRUE(revoke("ant"));
  EXPECT_TRUE(admit("ant", {other, open("ant")}));
  rates.clear();
  reopen();
  EXPECT_EQ(rates["ant"], 64U);
  EXPECT_TRUE(set_rate("ant", 0));
  reopen();
  EXPECT_EQ(rates["ant"], 0U);
}

TEST_F(Gate, FailedAttemptsAreLimitedByAddressAndTokensThatFitAreNot) {
  EXPECT_TRUE(admit("ant", {token, open("ant")}));
  const std::string code = open("bee");
  for (int i = 0; i < 2; ++i) EXPECT_EQ(admit("bee", {other, "guess"}).error().code, ErrorCode::refused);
  const auto limited = admit("bee", {other, code});
  ASSERT_FALSE(limited) << "not even the right code";
  EXPECT_EQ(limited.error().code, ErrorCode::unavailable);
  EXPECT_TRUE(admit("ant", {token, ""})) << "who is known gets in";
  EXPECT_TRUE(admit("bee", {other, code}, "10.0.0.2")) << "another address is not concerned";
  now += 1s;
  EXPECT_EQ(admit("bee", {token, "guess"}).error().code, ErrorCode::refused) << "looked at again";
}

TEST_F(Gate, AFullDiskOpensNothing) {
  const std::string code = open("ant");
  gate.reset();
  store.reset();
  store = open_sqlite_store(dir.path(), {.queue_bytes = 1}).value();  // every write is one too many
  gate = std::make_unique<RobotGate>(*store, RobotGate::Seams{[this] { return now_s; }, {}, {}});
  ASSERT_TRUE(gate->restore());
  EXPECT_EQ(admit("ant", {token, code}).error().code, ErrorCode::unavailable);
  EXPECT_EQ(admit("ant", {token, ""}).error().code, ErrorCode::refused) << "nothing was granted";
  bool failed = false;
  gate->open("bee", [&](const Result<std::string>& opened) { failed = !opened; });
  EXPECT_TRUE(failed);
  EXPECT_EQ(gate->robots().size(), 1U);
  EXPECT_FALSE(revoke("ant"));
  EXPECT_FALSE(admit("ant", {token, code})) << "revoked all the same, as long as this server lives";
}

}  // namespace
}  // namespace headframe
