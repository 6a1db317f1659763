// Robots that drive while the server merges: nothing wrong is told at any moment, and the end does not hang on how they
// came. The drives are those of `./run bench live` that once went wrong.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>

#include "tests/bench/live/live_sets.hpp"
#include "tests/bench/live/live_watch.hpp"

namespace headframe::bench {
namespace {

struct Drive {
  const char* set;
  std::vector<LiveConditions> conditions;
  std::size_t right_at_end;  // pairs, in each of the drives
};

const LiveConditions at_once{100, 1, Start::together, Clouds::at_once, false, false, 0};
const LiveConditions asked{6, 1, Start::together, Clouds::on_request, false, false, 5};
const LiveConditions another_first{6, 6, Start::together, Clouds::at_once, false, false, 1};
const LiveConditions after_each_other{20, 6, Start::one_after_another, Clouds::at_once, false, false, 0};

class LiveDrives : public ::testing::TestWithParam<Drive> {};

TEST_P(LiveDrives, TellNothingWrongAndEndTheSame) {
  const auto sets = live_sets("no recordings", 310000);
  const auto set = std::find_if(sets.begin(), sets.end(), [](const LiveSet& s) { return s.name == GetParam().set; });
  ASSERT_NE(set, sets.end());
  const std::vector<DrivenSession> sessions = set->driving();
  std::vector<const DrivenSession*> driving(sessions.size());
  std::transform(sessions.begin(), sessions.end(), driving.begin(), [](const DrivenSession& s) { return &s; });
  std::optional<std::map<NamedPair, EndState>> first;
  for (const LiveConditions& conditions : GetParam().conditions) {
    SCOPED_TRACE(text_of(conditions));
    LiveWatch watch;
    LiveRun run({}, driving, conditions, [&](const LiveRun& now) { watch.look(now); });
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

// A loop of three sessions that drift; a smooth tunnel with a short overlap; one that was merged wrongly at .987.
const std::array drives{Drive{"grid-310101", {at_once, another_first}, 3},
                        Drive{"straight-310104", {at_once, asked}, 1}, Drive{"straight-310109", {after_each_other}, 0}};
INSTANTIATE_TEST_SUITE_P(Drawn, LiveDrives, testing::ValuesIn(drives), [](const auto& drive) {
  std::string name = drive.param.set;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace headframe::bench
