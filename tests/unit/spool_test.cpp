#include "client/spool/spool.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <sstream>

#include "common/wire/limits.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

Hello rover() {
  Hello h;
  h.session.robot = "rover";
  h.sensor = {"os1-32", 32, 22.5F, 22.5F, 120};
  h.family = {{"scan_context", 1}, 2, 1};
  h.software = "test";
  return h;
}

Keyframe keyframe(std::uint64_t sequence) {
  Keyframe k;
  k.sequence = sequence;
  k.stamp_s = static_cast<double>(sequence) * 0.5;
  k.descriptor = {{1, 2}, {3}, PlaceClass::unknown};
  k.point_count = 5;
  return k;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

void write(const fs::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

class SpoolTest : public testing::Test {
 protected:
  Result<Spool> open(std::uint64_t quota = 1 << 20) { return Spool::open({folder_.path(), quota, false}, rover()); }
  fs::path log() const { return folder_.path() / "session.log"; }
  void fill(std::uint64_t keyframes) {
    auto spool = open();
    ASSERT_TRUE(spool) << spool.error().message;
    for (std::uint64_t i = spool->last_sequence() + 1; i <= keyframes; ++i)
      ASSERT_TRUE(spool->append(keyframe(i), "cloud " + std::to_string(i)));
  }
  /// The log of a run before and after its third keyframe.
  std::pair<std::string, std::string> logs_around_the_third() {
    fill(2);
    auto spool = open();
    std::string two = bytes_of(log());
    EXPECT_TRUE(spool->append(keyframe(3), "cloud 3"));
    return {two, bytes_of(log())};
  }
  TempDir folder_;
};

TEST_F(SpoolTest, ALogThatIsNoneIsLeftAsItIs) {
  const std::string noise = "\x9c\xe1\x07\xb3 anything at all that no spool has written";
  write(log(), noise);
  const auto spool = open();
  ASSERT_FALSE(spool);
  EXPECT_EQ(spool.error().code, ErrorCode::bad_input);
  EXPECT_EQ(bytes_of(log()), noise);
}

TEST_F(SpoolTest, RoomThatAPowerCutLeftUnwrittenIsATornEnd) {
  write(log(), std::string(5000, '\0'));
  EXPECT_TRUE(open());
}

TEST_F(SpoolTest, ASessionIsTheSameAfterReopening) {
  fill(3);
  SessionKey before;
  std::uint64_t id = 0;
  {
    auto spool = open();
    ASSERT_TRUE(spool);
    before = spool->identity().session;
    id = spool->identity().spool_id;
    ASSERT_TRUE(spool->acknowledge_keyframes(2));
    ASSERT_TRUE(spool->acknowledge_keyframes(1)) << "repeats are harmless";
    ASSERT_TRUE(spool->acknowledge_cloud(1));
    ASSERT_TRUE(spool->acknowledge_cloud(1));
  }
  const auto spool = open();
  ASSERT_TRUE(spool);
  EXPECT_TRUE(spool->resumed());
  EXPECT_TRUE(spool->warnings().empty());
  EXPECT_EQ(spool->identity().session, before);
  EXPECT_EQ(spool->identity().session.session.size(), 16U);
  EXPECT_EQ(spool->identity().spool_id, id);
  EXPECT_NE(id, 0U);
  EXPECT_EQ(spool->last_sequence(), 3U);
  EXPECT_EQ(spool->acknowledged_keyframes(), 2U);
  EXPECT_EQ(spool->acknowledged_clouds(), 1U);
  EXPECT_EQ(spool->held_clouds(), 2U);
  EXPECT_EQ(spool->next_held_cloud(1), 2U);
  EXPECT_EQ(spool->next_held_cloud(4), 0U);
  EXPECT_FALSE(spool->cloud(1));
  EXPECT_EQ(*spool->cloud(3), "cloud 3");
  EXPECT_EQ(spool->keyframe(2)->stamp_s, 1.0);
  EXPECT_FALSE(spool->keyframe(0));
  EXPECT_FALSE(spool->keyframe(4));
}

TEST_F(SpoolTest, ItBelongsToOneProcessOneRobotAndOneFamily) {
  const auto first = open();
  ASSERT_TRUE(first);
  const auto second = open();
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::refused);
}

TEST_F(SpoolTest, AnotherRobotOrFamilyIsRefused) {
  fill(1);
  Hello other = rover();
  other.session.robot = "crawler";
  EXPECT_EQ(Spool::open({folder_.path()}, other).error().code, ErrorCode::refused);
  other = rover();
  other.session.session = "another";
  EXPECT_EQ(Spool::open({folder_.path()}, other).error().code, ErrorCode::refused);
  other = rover();
  other.family.id.version = 2;
  const auto newer = Spool::open({folder_.path()}, other);
  EXPECT_EQ(newer.error().code, ErrorCode::refused);
  EXPECT_NE(newer.error().message.find("scan_context version 1 (2 + 1 values), not scan_context version 2"),
            std::string::npos)
      << newer.error().message;
  other = rover();
  other.family.q_size = 3;
  EXPECT_EQ(Spool::open({folder_.path()}, other).error().code, ErrorCode::refused);
  EXPECT_TRUE(open());
}

TEST_F(SpoolTest, SequencesHaveNoHoles) {
  auto spool = open();
  ASSERT_TRUE(spool);
  EXPECT_FALSE(spool->append(keyframe(2), ""));
  EXPECT_TRUE(spool->append(keyframe(1), ""));
  EXPECT_FALSE(spool->append(keyframe(1), ""));
  Keyframe bad = keyframe(2);
  bad.stamp_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(spool->append(bad, ""));
  EXPECT_EQ(spool->last_sequence(), 1U);
}

TEST_F(SpoolTest, KilledAtAnyByteOfTheLastRecordOnlyThatRecordIsGone) {
  const auto [two, three] = logs_around_the_third();
  ASSERT_GT(three.size(), two.size());
  for (std::size_t cut = two.size(); cut < three.size(); ++cut) {
    write(log(), std::string_view(three).substr(0, cut));
    {
      auto spool = open();
      ASSERT_TRUE(spool) << cut << ": " << spool.error().message;
      EXPECT_EQ(spool->last_sequence(), 2U) << cut;
      EXPECT_EQ(spool->warnings().size(), cut == two.size() ? 0U : 1U) << cut;
      EXPECT_FALSE(spool->holds_cloud(3)) << "a cloud without its keyframe is removed";
      ASSERT_TRUE(spool->append(keyframe(3), "cloud 3 again"));
    }
    const auto again = open();
    ASSERT_TRUE(again) << cut;
    EXPECT_TRUE(again->warnings().empty()) << cut;
    EXPECT_EQ(again->last_sequence(), 3U) << cut;
    EXPECT_EQ(*again->cloud(3), "cloud 3 again");
  }
}

TEST_F(SpoolTest, AFlippedByteIsNeverTakenForAKeyframe) {
  const auto [two, three] = logs_around_the_third();
  for (std::size_t at = 0; at < three.size(); ++at) {
    std::string flipped = three;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    write(log(), flipped);
    const auto spool = open();
    if (at < two.size()) {  // whole records follow: nothing is thrown away behind the operator's back
      ASSERT_FALSE(spool) << at;
      EXPECT_EQ(spool.error().code, ErrorCode::bad_input) << at;
      EXPECT_EQ(bytes_of(log()), flipped) << at;
    } else {
      ASSERT_TRUE(spool) << at;
      EXPECT_EQ(spool->last_sequence(), 2U) << at;
    }
  }
}

TEST_F(SpoolTest, ADamagedCloudIsAnErrorOfThatCloudAlone) {
  fill(2);
  const fs::path path = folder_.path() / "clouds" / "0000000001";
  std::string bytes = bytes_of(path);
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  write(path, bytes);
  auto spool = open();
  ASSERT_TRUE(spool);
  EXPECT_FALSE(spool->cloud(1));
  EXPECT_EQ(*spool->cloud(2), "cloud 2");
  spool->drop_cloud(1);
  EXPECT_FALSE(spool->holds_cloud(1));
  EXPECT_EQ(spool->dropped_clouds(), 1U);
}

TEST_F(SpoolTest, TheQuotaDropsTheOldestCloudsAndNoKeyframe) {
  const std::string cloud(91, 'x');  // 100 bytes with the record's header
  {
    auto spool = open(300);
    ASSERT_TRUE(spool);
    for (std::uint64_t i = 1; i <= 3; ++i) ASSERT_TRUE(spool->append(keyframe(i), cloud));
    EXPECT_EQ(spool->held_clouds(), 3U) << "exactly the quota is allowed";
    ASSERT_TRUE(spool->append(keyframe(4), cloud));
    EXPECT_EQ(spool->held_clouds(), 3U);
    EXPECT_EQ(spool->next_held_cloud(1), 2U);
    EXPECT_EQ(spool->last_sequence(), 4U);
  }
  const auto spool = open(299);
  ASSERT_TRUE(spool);
  EXPECT_EQ(spool->held_clouds(), 2U);
  EXPECT_EQ(spool->dropped_clouds(), 2U);
  EXPECT_EQ(spool->last_sequence(), 4U);
}

TEST_F(SpoolTest, ADiskWithoutRoomCostsCloudsAndNoKeyframe) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  auto spool = open();
  ASSERT_TRUE(spool);
  ASSERT_TRUE(spool->append(keyframe(1), std::string(1000, 'x')));
  const rlimit small{20'000, before.rlim_max};  // of every file: a cloud does not fit
  ::setrlimit(RLIMIT_FSIZE, &small);
  const auto added = spool->append(keyframe(2), std::string(50'000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_TRUE(added) << added.error().message;
  EXPECT_EQ(spool->last_sequence(), 2U);
  EXPECT_EQ(spool->held_clouds(), 0U) << "the older one was given up for it first";
  EXPECT_EQ(spool->dropped_clouds(), 2U);
  EXPECT_TRUE(spool->append(keyframe(3), "cloud"));
  EXPECT_EQ(spool->next_held_cloud(1), 3U);
  EXPECT_TRUE(spool->keyframe(2));
}

TEST_F(SpoolTest, ADirectoryThatCanNotBeMadeIsOneClearLine) {
  write(folder_.path() / "file", "x");
  const auto spool = Spool::open({folder_.path() / "file" / "spool"}, rover());
  ASSERT_FALSE(spool);
  EXPECT_EQ(spool.error().code, ErrorCode::unavailable);
  EXPECT_NE(spool.error().message.find("spool"), std::string::npos);
}

TEST_F(SpoolTest, EveryOpeningIsARunAndTheNewestAreTold) {
  std::vector<std::uint64_t> all;
  for (std::size_t i = 0; i < limits::spool_runs + 3; ++i) {
    auto spool = open();
    ASSERT_TRUE(spool);
    all.push_back(spool->identity().spool_runs.back());
    EXPECT_TRUE(i != 1 || spool->run_welcomed());
    ASSERT_TRUE(from_proto(to_proto(spool->identity())));
    EXPECT_TRUE(i >= limits::spool_runs || spool->identity().spool_runs == all) << i;
  }
  EXPECT_EQ(std::set<std::uint64_t>(all.begin(), all.end()).size(), all.size()) << "each is another";
  const auto spool = open();
  auto told = spool->identity().spool_runs;
  ASSERT_EQ(told.size(), limits::spool_runs);
  EXPECT_EQ(told.front(), all[1]) << "the one that the server knows";
  EXPECT_TRUE(std::equal(told.begin() + 1, told.end() - 1, all.end() - static_cast<std::ptrdiff_t>(told.size() - 2)));
}

}  // namespace
}  // namespace headframe
