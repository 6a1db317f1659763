#include "server/cli/table.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace headframe {
namespace {

const Table sessions{{{"session"}, {"keyframes", true}, {"sensor", false, 2}, {"rate", true, 1}},
                     {{"alpha/run", "12", "os1-32", "1.0 kB/s"}, {"beta/run", "7", "vlp16", "2.0 kB/s"}}};

std::size_t widest(const std::string& text) {
  std::size_t most = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) most = std::max(most, line.size());
  return most;
}

TEST(Table, SparesColumnsBeforeItCutsWords) {
  const std::string whole = sessions.text(0);
  EXPECT_EQ(whole,
            "session    keyframes  sensor      rate\n"
            "alpha/run         12  os1-32  1.0 kB/s\n"
            "beta/run           7  vlp16   2.0 kB/s\n");
  EXPECT_EQ(sessions.text(38), whole);
  EXPECT_EQ(sessions.text(37),
            "session    keyframes      rate\n"
            "alpha/run         12  1.0 kB/s\n"
            "beta/run           7  2.0 kB/s\n")
      << "the sensor goes first";
  EXPECT_EQ(sessions.text(30), sessions.text(37));
  EXPECT_EQ(sessions.text(29),
            "session    keyframes\n"
            "alpha/run         12\n"
            "beta/run           7\n");
  for (std::size_t width = 10; width <= 40; ++width) EXPECT_LE(widest(sessions.text(width)), width + 4) << width;
}

/// A long name is cut before a column is spared for it.
TEST(Table, LongNamesAreCut) {
  Table table = sessions;
  table.rows[0][0] = std::string(60, 'x');
  const std::string text = table.text(60);
  EXPECT_NE(text.find("sensor"), std::string::npos) << text;
  EXPECT_NE(text.find("x\u2026"), std::string::npos) << text;
}

}  // namespace
}  // namespace headframe
