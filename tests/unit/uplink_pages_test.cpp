// Transforms that come in pages, put together by the robot. transform_pages_test looks at how they are cut.
#include <algorithm>

#include "common/wire/convert.hpp"
#include "tests/support/uplink_fixture.hpp"

namespace headframe {
namespace {

constexpr int on_a_page = 100;

/// As the server sends them; no more than a page has come as one message.
std::vector<v1::ServerMessage> pages_of(int sessions, std::uint64_t revision) {
  const int pages = (sessions + on_a_page - 1) / on_a_page;
  std::vector<v1::ServerMessage> out(static_cast<std::size_t>(pages));
  for (int i = 0; i < sessions; ++i) {
    auto& update = *out[static_cast<std::size_t>(i / on_a_page)].mutable_transform_update();
    auto& session = *update.add_sessions();
    *session.mutable_session() = to_proto(SessionKey{"robot " + std::to_string(i), "run"});
    *session.mutable_t_component_session() = to_proto(pose_from_yaw(0.001 * i, {1.0 * i, 2, 3}));
  }
  for (int page = 0; page < pages; ++page) {
    auto& update = *out[static_cast<std::size_t>(page)].mutable_transform_update();
    update.set_revision(revision);
    update.set_component(3);
    *update.mutable_anchor() = to_proto(SessionKey{"robot 0", "run"});
    if (pages > 1) update.set_page(static_cast<std::uint32_t>(page));
    if (pages > 1) update.set_pages(static_cast<std::uint32_t>(pages));
  }
  auto& withdrawn = *out.back().mutable_transform_update()->add_withdrawn();
  *withdrawn.mutable_a() = to_proto(SessionKey{"x", "run"});
  *withdrawn.mutable_b() = to_proto(SessionKey{"y", "run"});
  return out;
}

class PagedUplink : public UplinkProtocolTest {
 protected:
  void SetUp() override {
    start();
    (void)sent();
    v1::ServerMessage welcome;
    welcome.mutable_welcome()->set_protocol_version(protocol_version);
    feed(welcome);
    told();
  }
  void feed(const v1::ServerMessage& message) {
    std::string bytes;
    ASSERT_TRUE(append_frame(bytes, message.SerializeAsString()));
    const auto events = link_->receive(bytes, now_);
    events_.insert(events_.end(), events.begin(), events.end());
  }
  /// The updates that the robot was given since it was asked last.
  std::vector<Transforms> told() {
    std::vector<Transforms> out;
    for (const auto& event : events_)
      if (const auto* t = std::get_if<Transforms>(&event)) out.push_back(*t);
    events_.clear();
    return out;
  }
};

TEST_F(PagedUplink, PutsPagesTogetherAndTellsThemOnce) {
  const auto pages = pages_of(500, 7);
  ASSERT_GT(pages.size(), 3U);
  for (std::size_t i = 0; i + 1 < pages.size(); ++i) feed(pages[i]);
  EXPECT_TRUE(told().empty()) << "half an update is none";
  feed(pages.back());
  const auto whole = told();
  ASSERT_EQ(whole.size(), 1U);
  ASSERT_EQ(whole[0].sessions.size(), 500U);
  EXPECT_EQ(whole[0].sessions[499].session.robot, "robot 499");
  EXPECT_EQ(whole[0].withdrawn.size(), 1U);
  EXPECT_FALSE(link_->ended());
}

TEST_F(PagedUplink, PassesOverPagesThatDoNotFollow) {
  const auto old = pages_of(500, 7), now = pages_of(300, 8);
  feed(old[0]);
  feed(old[1]);
  feed(now[1]);  // its first was never sent
  for (std::size_t i = 2; i < old.size(); ++i) feed(old[i]);
  EXPECT_TRUE(told().empty());
  feed(old[0]);
  feed(old[2]);
  for (const auto& page : now) feed(page);
  const auto whole = told();
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].revision, 8U);
  EXPECT_EQ(whole[0].sessions.size(), 300U);
  feed(pages_of(2, 9).front());
  EXPECT_EQ(told().size(), 1U) << "one message is an update as before";
  EXPECT_FALSE(link_->ended());
}

}  // namespace
}  // namespace headframe
