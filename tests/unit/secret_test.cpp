#include "common/security/secret.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "common/security/enrolment.hpp"
#include "common/security/private_file.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

TEST(Secret, HexIsReadAsItIsWritten) {
  const std::string secret = random_secret(token_bytes);
  EXPECT_EQ(secret.size(), token_bytes);
  EXPECT_NE(secret, random_secret(token_bytes));
  EXPECT_EQ(from_hex(to_hex(secret), token_bytes).value(), secret);
  EXPECT_EQ(from_hex("00fFA0", 3).value(), std::string("\0\xff\xa0", 3));
  for (const std::string bad : {"", "00", "0000000", "00000g", " 00000", "-00000"})
    EXPECT_FALSE(from_hex(bad, 3)) << bad;
}

TEST(Secret, DigestIsTheStandardOne) {  // FIPS 180-2, appendix B.1
  EXPECT_EQ(to_hex(sha256("abc")), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Secret, OnlyEqualBytesAreTheSame) {
  EXPECT_TRUE(same_secret("abc", "abc"));
  EXPECT_TRUE(same_secret("", ""));
  EXPECT_FALSE(same_secret("abc", "abd"));
  EXPECT_FALSE(same_secret("abc", "ab"));
  EXPECT_FALSE(same_secret(std::string_view("a\0b", 3), std::string_view("a\0c", 3)));
}

TEST(Enrolment, IsReadAsItIsWritten) {
  const Enrolment enrolment{sha256("certificate"), random_secret(code_bytes)};
  const std::string text = to_string(enrolment);
  std::string version_2 = text;
  version_2[2] = '2';
  const auto read = parse_enrolment(text);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->fingerprint, enrolment.fingerprint);
  EXPECT_EQ(read->code, enrolment.code);
  for (const std::string& bad : {std::string(), text.substr(1), text.substr(0, text.size() - 1), text + "0", version_2,
                                 text.substr(0, 68), std::string("hf1--")}) {
    const auto refused = parse_enrolment(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().message.find(to_hex(enrolment.code).substr(0, 8)), std::string::npos);
  }
}

TEST(Fingerprint, MayHaveColons) {
  const std::string digits = to_hex(sha256("certificate"));
  std::string with_colons;
  for (std::size_t i = 0; i < digits.size(); i += 2) with_colons.append(i == 0 ? "" : ":").append(digits, i, 2);
  EXPECT_EQ(parse_fingerprint(digits).value(), sha256("certificate"));
  EXPECT_EQ(parse_fingerprint(with_colons).value(), sha256("certificate"));
  EXPECT_FALSE(parse_fingerprint(digits.substr(2)));
}

TEST(PrivateFile, IsOnlyItsOwners) {
  const TempDir dir;
  const auto path = dir.path() / "token";
  EXPECT_EQ(read_private_file(path).error().code, ErrorCode::not_found);
  ASSERT_TRUE(write_private_file(path, "one"));
  ASSERT_TRUE(write_private_file(path, "two"));
  struct stat facts {};
  ASSERT_EQ(::stat(path.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0600U);
  EXPECT_EQ(read_private_file(path).value(), "two");
  for (const mode_t shared : {0640U, 0604U, 0620U}) {
    ASSERT_EQ(::chmod(path.c_str(), shared), 0);
    const auto read = read_private_file(path);
    ASSERT_FALSE(read) << shared;
    EXPECT_EQ(read.error().code, ErrorCode::refused);
    EXPECT_NE(read.error().message.find("chmod 600"), std::string::npos);
  }
}

TEST(PrivateFile, ARestOfACrashIsReplaced) {
  const TempDir dir;
  std::ofstream(dir.path() / "token.part") << "half";
  ASSERT_TRUE(write_private_file(dir.path() / "token", "whole"));
  EXPECT_EQ(read_private_file(dir.path() / "token").value(), "whole");
  EXPECT_FALSE(std::filesystem::exists(dir.path() / "token.part"));
  EXPECT_EQ(write_private_file(dir.path() / "none" / "token", "x").error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace headframe
