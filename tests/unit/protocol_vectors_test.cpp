// The protocol's test vectors say what the code does: both the files, and the bytes that older robots once sent.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/vectors/vectors.hpp"

namespace headframe::vectors {
namespace {

Json read(const std::string& name) {
  std::ifstream in(std::string(HEADFRAME_SOURCE_DIR "/proto/headframe/v1/vectors/") + name + ".json");
  return Json::parse(in, nullptr, false);
}

TEST(ProtocolVectors, AreWhatTheCodeMakes) {
  for (const auto& file : all_files()) {
    const Json committed = read(file.name);
    ASSERT_FALSE(committed.is_discarded()) << file.name << ".json: no JSON; run headframe-make-vectors";
    EXPECT_EQ(difference(committed, Json::parse(to_text(file.content))), "") << "in " << file.name << ".json";
  }
}

TEST(ProtocolVectors, AChangeOfAnyNumberOrByteIsSeen) {
  const Json good{{"a", {1.5, "ff"}}, {"b", 7}};
  EXPECT_EQ(difference(good, good), "");
  EXPECT_EQ(difference(good, {{"a", {1.500001, "ff"}}, {"b", 7}}), "") << "a compiler's rounding";
  EXPECT_NE(difference(good, {{"a", {1.501, "ff"}}, {"b", 7}}), "");
  EXPECT_NE(difference(good, {{"a", {1.5, "fe"}}, {"b", 7}}), "");
  EXPECT_NE(difference(good, {{"a", {1.5, "ff"}}, {"b", 8}}), "");
  EXPECT_NE(difference(good, {{"a", {1.5, "ff"}}}), "");
  EXPECT_NE(difference({{"a", {1.5, "ff"}}}, good), "");
}

}  // namespace
}  // namespace headframe::vectors
