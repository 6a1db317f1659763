// Which of a robot's connections the hub speaks to.
#include "server/net/session_hub.hpp"

#include "tests/support/nobodys_news.hpp"
#include "tests/support/robot_bytes.hpp"
#include "tests/support/stores.hpp"

namespace headframe {
namespace {

/// What a connection was told, in words.
class HeardLink : public RobotLink {
 public:
  std::vector<std::string> heard;
  void settled(std::size_t, const Result<void>&) override {}
  void keyframes_durable(std::uint64_t) override {}
  void cloud_durable(std::uint64_t) override {}
  void cloud_refused(std::uint64_t, const std::string&) override {}
  void request_submap(const std::vector<std::uint64_t>&) override { heard.push_back("request"); }
  void update_transform(std::shared_ptr<const std::string>) override { heard.push_back("transform"); }
  void stand_by() override { heard.push_back("stand by"); }
  void close(v1::ErrorKind, const std::string&, bool permanent) override {
    heard.push_back(permanent ? "closed for good" : "closed");
  }
};

class News : public NobodysNews {
 public:
  std::vector<std::string> heard;
  void robot_came(SessionId, bool answers) override { heard.push_back(answers ? "came" : "came and gives no clouds"); }
  void robot_left(SessionId) override { heard.push_back("left"); }
};

using Words = std::vector<std::string>;

class Hub : public testing::Test {
 protected:
  static Hello hello(bool spare) {
    Hello h = robot_hello();
    h.spool_runs = {10};
    h.spare = spare;
    return h;
  }
  void SetUp() override {
    id_ = hub_.admit(hello(false), first_).value().session;
    const SessionId other = hub_.admit(robot_hello("bee"), std::make_shared<HeardLink>()).value().session;
    ASSERT_EQ(hub_.admit(hello(true), spare_).value().session, id_);
    atlas_.components.push_back({id_, {{id_, Pose::Identity()}, {other, Pose::Identity()}}});
  }
  void TearDown() override { store_.reset(); }  // its callbacks find the hub

  TempDir dir_;
  std::unique_ptr<Store> store_ = open(dir_);
  News news_;
  SessionHub hub_{*store_, news_};
  std::shared_ptr<HeardLink> first_ = std::make_shared<HeardLink>(), spare_ = std::make_shared<HeardLink>();
  SessionId id_ = 0;
  Atlas atlas_;
};

TEST_F(Hub, TheSpareHearsNothingUntilItTakesOverAndThenAllThatCounts) {
  hub_.publish(atlas_, atlas_.components);
  hub_.request_submap(id_, {1});
  EXPECT_EQ(first_->heard, (Words{"transform", "request"}));
  EXPECT_EQ(spare_->heard, Words{});
  news_.heard.clear();
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(spare_->heard, Words{"transform"});
  EXPECT_EQ(news_.heard, (Words{"left", "came"})) << "what was asked of the first has to be asked again";
  hub_.request_submap(id_, {1});
  EXPECT_EQ(spare_->heard, (Words{"transform", "request"}));
  EXPECT_EQ(first_->heard, (Words{"transform", "request", "stand by"}));
  hub_.take(id_, TakenOver{}, first_);
  hub_.request_submap(id_, {1});
  EXPECT_EQ(first_->heard, (Words{"transform", "request", "stand by", "transform", "request"}));
}

TEST_F(Hub, ASpareThatLeavesIsNoLossAndTheFirstOneIs) {
  news_.heard.clear();
  hub_.left(id_, spare_.get());
  EXPECT_EQ(news_.heard, Words{});
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(news_.heard, Words{}) << "it is not there any more";
  hub_.left(id_, first_.get());
  EXPECT_EQ(news_.heard, Words{"left"});
}

TEST_F(Hub, ASpareCarriesWhatNobodyElseCarries) {
  hub_.publish(atlas_, atlas_.components);
  hub_.left(id_, first_.get());
  const auto late = std::make_shared<HeardLink>();
  EXPECT_TRUE(hub_.admit(hello(true), late).value().transform);
  hub_.request_submap(id_, {1});
  EXPECT_EQ(late->heard, Words{"request"});
  hub_.take(id_, TakenOver{}, late);
  EXPECT_EQ(late->heard, (Words{"request", "transform"})) << "it did not listen before";
  hub_.take(id_, TakenOver{}, spare_);
  EXPECT_EQ(late->heard.back(), "stand by");
}

TEST_F(Hub, ARobotThatIsRevokedLosesItsSparesToo) {
  hub_.end_robot("ant", "revoked");
  EXPECT_EQ(first_->heard, Words{"closed for good"});
  EXPECT_EQ(spare_->heard, Words{"closed for good"});
}

TEST_F(Hub, ANewConnectionOfTheSameRunLeavesItsSparesAndOfAnotherDoesNot) {
  const auto second = std::make_shared<HeardLink>(), third = std::make_shared<HeardLink>();
  ASSERT_TRUE(hub_.admit(hello(false), second));
  EXPECT_EQ(first_->heard, Words{"closed"});
  EXPECT_EQ(spare_->heard, Words{});
  Hello anew = hello(false);
  anew.spool_runs = {10, 11};
  ASSERT_TRUE(hub_.admit(anew, third));
  EXPECT_EQ(second->heard, Words{"closed"});
  EXPECT_EQ(spare_->heard, Words{"closed"});
}

}  // namespace
}  // namespace headframe
