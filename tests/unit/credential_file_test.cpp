#include "client/credential/credential_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "common/security/enrolment.hpp"
#include "common/security/private_file.hpp"
#include "common/security/secret.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

struct Credentials : testing::Test {
  Result<CredentialFile> open(const std::string& enrolment = "", const std::string& robot = "ant") const {
    return CredentialFile::open(path, robot, enrolment);
  }
  static std::string enrolment() { return to_string(Enrolment{sha256("server"), random_secret(code_bytes)}); }

  TempDir dir;
  const std::filesystem::path path = dir.path() / "ant.credential";
};

TEST_F(Credentials, ACodeIsKeptUntilTheServerHasConfirmedIt) {
  const std::string first = enrolment();
  const auto made = open(first);
  ASSERT_TRUE(made) << made.error().message;
  const auto credential = made->credential();
  EXPECT_EQ(credential.fingerprint, sha256("server"));
  EXPECT_EQ(credential.code, parse_enrolment(first)->code);
  EXPECT_EQ(credential.token.size(), token_bytes);

  auto again = open();  // as after a crash
  ASSERT_TRUE(again);
  EXPECT_EQ(again->credential().token, credential.token) << "the same token with the same code";
  EXPECT_EQ(again->credential().code, credential.code);
  ASSERT_TRUE(again->confirmed());
  for (const std::string& given : {std::string(), first}) {  // the start file may go on to name the used one
    const auto later = open(given);
    ASSERT_TRUE(later);
    EXPECT_EQ(later->credential().token, credential.token);
    EXPECT_EQ(later->credential().code, "");
  }
  const auto anew = open(enrolment());
  ASSERT_TRUE(anew);
  EXPECT_NE(anew->credential().token, credential.token);
  EXPECT_NE(anew->credential().code, "");
}

TEST_F(Credentials, TheirFolderIsMade) {
  const auto deep = dir.path() / "robots" / "ant" / "credential";
  EXPECT_TRUE(CredentialFile::open(deep, "ant", enrolment()));
  EXPECT_TRUE(CredentialFile::open(deep, "ant", "")) << "and found again";
  EXPECT_FALSE(CredentialFile::open(dir.path() / "none" / "credential", "ant", ""));
  EXPECT_FALSE(std::filesystem::exists(dir.path() / "none")) << "not for nothing";
}

TEST_F(Credentials, AreTheirOwnersAlone) {
  ASSERT_TRUE(open(enrolment()));
  struct stat facts {};
  ASSERT_EQ(::stat(path.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0600U);
  EXPECT_EQ(open("", "bee").error().code, ErrorCode::refused);
  ASSERT_EQ(::chmod(path.c_str(), 0644), 0);
  EXPECT_EQ(open().error().code, ErrorCode::refused);
}

TEST_F(Credentials, FaultsAreSaidWithoutSecrets) {
  const auto none = open();
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(none.error().message.find("headframe robot add ant"), std::string::npos);
  EXPECT_EQ(open("hf1-nonsense").error().code, ErrorCode::bad_input);
  EXPECT_FALSE(std::filesystem::exists(path));

  ASSERT_TRUE(open(enrolment()));
  const std::string whole = *read_private_file(path);
  for (const std::string& damaged : {whole.substr(0, 40), whole.substr(5), std::string("x"), std::string()}) {
    ASSERT_TRUE(write_private_file(path, damaged));
    const auto refused = open();
    ASSERT_FALSE(refused) << damaged;
    EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
  }
}

}  // namespace
}  // namespace headframe
