// Robots that drive while the server merges: nothing wrong is told at any moment, and the end does not hang on how they
// came. Drives of `./run bench live` through mines in which that went wrong once.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>

#include "tests/bench/live/live_sets.hpp"
#include "tests/bench/live/live_watch.hpp"

namespace headframe::bench {
namespace {

struct Drives {
  const char* set;
  std::vector<std::string> conditions;  // as the bench prints them
  std::size_t right_at_end;             // pairs, in each of the drives
};

class LiveDrives : public ::testing::TestWithParam<Drives> {};

TEST_P(LiveDrives, TellNothingWrongAndEndTheSame) {
  const auto sets = live_sets("no recordings", 310000);
  const auto set = std::find_if(sets.begin(), sets.end(), [](const LiveSet& s) { return s.name == GetParam().set; });
  ASSERT_NE(set, sets.end());
  const std::vector<DrivenSession> sessions = set->driving();
  std::vector<const DrivenSession*> driving(sessions.size());
  std::transform(sessions.begin(), sessions.end(), driving.begin(), [](const DrivenSession& s) { return &s; });
  std::optional<std::map<NamedPair, EndState>> first;
  for (const std::string& wanted : GetParam().conditions) {
    SCOPED_TRACE(wanted);
    const auto conditions = std::find_if(set->conditions.begin(), set->conditions.end(),
                                         [&](const LiveConditions& c) { return text_of(c) == wanted; });
    ASSERT_NE(conditions, set->conditions.end());
    LiveWatch watch;
    LiveRun run({}, driving, *conditions, [&](const LiveRun& now) { watch.look(now); });
    run.drive();
    const auto end = LiveWatch::end_of(run);
    run.ask_for_merges();
    EXPECT_TRUE(differences(end, LiveWatch::end_of(run)).empty()) << "asking changes nothing";
    watch.finish(run);
    EXPECT_TRUE(watch.wrong().empty());
    EXPECT_EQ(
        std::count_if(watch.right().begin(), watch.right().end(), [](const Stood& stood) { return stood.at_end; }),
        static_cast<std::ptrdiff_t>(GetParam().right_at_end));
    if (!first) first = end;
    for (const std::string& difference : differences(end, *first)) ADD_FAILURE() << difference;
  }
}

// A loop of three sessions that drift; copies, of which few clouds show more than there are; a smooth tunnel with a
// short overlap; one that was merged wrongly at .987.
const std::array drives{Drives{"grid-310101", {"20x busy, together", "100x, together"}, 3},
                        Drives{"look_alike-310004", {"100x, together", "6x, together, clouds asked"}, 1},
                        Drives{"straight-310104", {"100x, together", "6x, together, clouds asked"}, 1},
                        Drives{"straight-310109", {"6x, one joins"}, 0}};
INSTANTIATE_TEST_SUITE_P(Drawn, LiveDrives, testing::ValuesIn(drives), [](const auto& drive) {
  std::string name = drive.param.set;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace headframe::bench
