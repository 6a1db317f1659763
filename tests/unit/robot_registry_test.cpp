#include "server/security/robot_registry.hpp"

#include <gtest/gtest.h>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

struct Registry : testing::Test {
  std::string open(const std::string& name = "ant") { return registry.open(name, now_s).value().code; }
  bool admits(const std::string& shown, const std::string& code = "", const std::string& name = "ant") {
    const auto admitted = registry.admit(name, {shown, code}, now_s);
    why = admitted ? "" : admitted.error().message;
    EXPECT_TRUE(admitted || admitted.error().code == ErrorCode::refused);
    return admitted.has_value();
  }
  /// The refusal says it.
  bool says(const std::string& words) const { return why.find(words) != std::string::npos; }

  RobotRegistry registry;
  double now_s = 1000;
  const std::string token = random_secret(token_bytes), other = random_secret(token_bytes);
  std::string why;
};

TEST_F(Registry, ACodeMakesATokenTheRobotsOnce) {
  EXPECT_FALSE(admits(token)) << "nobody is known";
  const std::string code = open();
  EXPECT_FALSE(admits(token)) << "a name is not enough";
  EXPECT_FALSE(admits("", code)) << "a code alone is none either";
  EXPECT_TRUE(admits(token, code));
  EXPECT_TRUE(admits(token));
  EXPECT_TRUE(admits(token, code)) << "the answer was lost, it asks again";
  EXPECT_FALSE(admits(other, code)) << "another one with the used code";
  EXPECT_TRUE(says("was used")) << why;
  EXPECT_FALSE(admits(other));
  EXPECT_TRUE(says("not its credential")) << why;
  EXPECT_TRUE(registry.holds("ant", token));
  EXPECT_FALSE(registry.holds("ant", other));
}

TEST_F(Registry, AnotherRobotsSecretsAreNone) {
  const std::string ants = open("ant"), bees = open("bee");
  EXPECT_FALSE(admits(token, bees, "ant"));
  EXPECT_TRUE(admits(token, ants, "ant"));
  EXPECT_TRUE(admits(other, bees, "bee"));
  EXPECT_FALSE(admits(token, "", "bee"));
  EXPECT_FALSE(admits(token, "", "wasp"));
}

TEST_F(Registry, ACodeExpiresAtItsTime) {
  std::string code = open();
  now_s += RobotRegistry::code_lifetime_s;
  EXPECT_FALSE(admits(token, code));
  EXPECT_TRUE(says("expired")) << why;
  code = open();
  now_s += RobotRegistry::code_lifetime_s - 1;
  EXPECT_TRUE(admits(token, code));
}

TEST_F(Registry, OnlyTheLastCodeCounts) {
  const std::string first = open(), second = open();
  EXPECT_FALSE(admits(token, first));
  EXPECT_TRUE(admits(token, second));
}

TEST_F(Registry, ANewCodeReplacesTheOldCredentialWhenItIsUsed) {
  EXPECT_TRUE(admits(token, open()));
  const std::string code = open();
  EXPECT_TRUE(admits(token)) << "until then it stays";
  EXPECT_TRUE(admits(other, code));
  EXPECT_FALSE(admits(token));
}

TEST_F(Registry, ARevokedRobotIsToldSoAndMayEnrolAnew) {
  EXPECT_EQ(registry.revoke("ant").error().code, ErrorCode::not_found);
  EXPECT_TRUE(admits(token, open()));
  const std::string unused = open();
  ASSERT_TRUE(registry.revoke("ant"));
  EXPECT_FALSE(registry.holds("ant", token));
  EXPECT_FALSE(admits(token));
  EXPECT_TRUE(says("revoked")) << why;
  EXPECT_FALSE(admits(other));
  EXPECT_FALSE(says("revoked")) << "that is not a stranger's business: " << why;
  EXPECT_FALSE(admits(token, unused)) << "an open code ends too";
  const std::string code = open();
  EXPECT_FALSE(admits(token)) << "a new code alone brings nothing back";
  EXPECT_TRUE(admits(token, code));
  EXPECT_TRUE(admits(token));
}

TEST_F(Registry, KeepsNoSecretsAndComesBackFromWhatIsStored) {
  const std::string code = open();
  EXPECT_TRUE(admits(token, code));
  const std::string later = open();
  for (const RobotRecord& robot : registry.robots())
    for (const std::string& secret : {token, code, later}) {
      EXPECT_EQ(robot.token_digest.find(secret), std::string::npos);
      EXPECT_EQ(robot.code_digest.find(secret), std::string::npos);
    }
  RobotRegistry restored;
  restored.restore(registry.robots());
  EXPECT_TRUE(restored.holds("ant", token));
  EXPECT_TRUE(restored.admit("ant", {other, later}, now_s));
}

TEST_F(Registry, WhatCouldNotBeStoredIsTakenBack) {
  const auto opened = registry.open("ant", now_s);
  const auto redeemed = registry.admit("ant", {token, opened->code}, now_s);
  ASSERT_TRUE(redeemed && *redeemed);
  registry.take_back(**redeemed);
  EXPECT_FALSE(admits(token));
  EXPECT_TRUE(admits(other, opened->code)) << "the code is open again";
  registry.take_back(**redeemed);
  EXPECT_TRUE(admits(other)) << "an old change does not undo a newer one";
  registry.take_back(registry.open("bee", now_s)->change);
  EXPECT_EQ(registry.robots().size(), 1U);
}

TEST_F(Registry, RefusalsDoNotRepeatSecrets) {
  const std::string code = open();
  admits(other, code + "x");
  EXPECT_EQ(why.find(code), std::string::npos);
  EXPECT_EQ(why.find(to_hex(code)), std::string::npos);
  EXPECT_EQ(registry.open("a/b", now_s).error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(registry.open("", now_s).error().code, ErrorCode::invalid_argument);
}

}  // namespace
}  // namespace headframe
