#include "common/printable.hpp"

#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <random>
#include <sstream>

#include "common/wire/convert.hpp"
#include "server/support/printable_log.hpp"
#include "tests/support/robot_bytes.hpp"

namespace headframe {
namespace {

TEST(Printable, LeavesWhatPeopleWrite) {
  for (const char* text : {"north drift", "Förderkorb 3", "забой", "坑道", "\xF0\x9F\x9A\x9C", ""})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, TakesAwayWhatForgesLinesAndMovesCursors) {
  EXPECT_EQ(printable("1.0)\n[info] robot admin has enrolled"), "1.0)?[info] robot admin has enrolled");
  EXPECT_EQ(printable("\x1b[2Ja\rb\x7f"), "?[2Ja?b?");
  EXPECT_EQ(printable("a\xC2\x9B"
                      "31mb\xC2\x85"
                      "c"),
            "a?31mb?c")
      << "C1 in UTF-8";
  EXPECT_EQ(printable("a\x9B"
                      "b"),
            "a?b")
      << "C1 as a byte";
  EXPECT_EQ(printable("\xE2\x80\xAE"
                      "nimda\xE2\x81\xA6"),
            "?nimda?")
      << "right to left";
  EXPECT_EQ(printable("ad\xE2\x80\x8Bmin\xEF\xBB\xBF"), "ad?min?") << "invisible";
  EXPECT_EQ(printable("a\xE2\x80\xA8"
                      "b"),
            "a?b")
      << "a line separator";
  EXPECT_EQ(printable("\xC0\x8A|\xED\xA0\x80|\xF4\x90\x80\x80|\xE2\x80"), "??|???|????|??") << "no UTF-8";
}

TEST(Printable, IsItselfPrintableWhateverCame) {
  std::mt19937 rng(1);
  for (int i = 0; i < 20000; ++i) {
    std::string text(rng() % 12, ' ');
    for (char& c : text) c = static_cast<char>(rng());
    const std::string once = printable(text);
    ASSERT_EQ(printable(once), once);
    for (const char c : once) ASSERT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
  }
}

TEST(Printable, ALogHasOneLineAnEntry) {
  std::ostringstream out;
  spdlog::logger log("t", std::make_shared<spdlog::sinks::ostream_sink_st>(out));
  log.set_formatter(printable_log());
  log.info("robot x connected ({})", "1.0)\n[2026] [info] robot admin has enrolled\x1b[2J");
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_NE(text.find("1.0)?[2026]"), std::string::npos) << text;
}

TEST(Printable, NamesAndSoftwareOfAHelloAreCheckedAtTheDoor) {
  for (const char* name : {"a\xC2\x85"
                           "b",
                           "\xE2\x80\xAE"
                           "nimda",
                           "\x9B"
                           "31m",
                           "ad\xE2\x80\x8Bmin"}) {
    EXPECT_FALSE(check_name("robot", name)) << name;
  }
  EXPECT_TRUE(check_name("robot", "Förderkorb 3"));
  v1::Hello message = to_proto(robot_hello());
  message.set_software("1.0)\nrobot admin has enrolled");
  EXPECT_EQ(from_proto(message)->software, "1.0)?robot admin has enrolled");
}

}  // namespace
}  // namespace headframe
