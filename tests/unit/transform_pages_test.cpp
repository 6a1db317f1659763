// Transforms of a component that fits no frame, cut into pages. uplink_pages_test puts them together again.
#include "server/net/transform_pages.hpp"

#include <gtest/gtest.h>

#include "common/wire/convert.hpp"
#include "common/wire/frame_codec.hpp"
#include "server/net/robot_outbox.hpp"

namespace headframe {
namespace {

v1::TransformUpdate update_of(int sessions, std::uint64_t revision = 7) {
  v1::TransformUpdate update;
  update.set_revision(revision);
  update.set_component(3);
  *update.mutable_anchor() = to_proto(SessionKey{"robot 0", "run"});
  for (int i = 0; i < sessions; ++i) {
    auto& session = *update.add_sessions();
    *session.mutable_session() = to_proto(SessionKey{"robot " + std::to_string(i), "run"});
    *session.mutable_t_component_session() = to_proto(pose_from_yaw(0.001 * i, {1.0 * i, 2, 3}));
  }
  update.add_withdrawn()->set_reason("contradicted");
  *update.mutable_withdrawn(0)->mutable_a() = to_proto(SessionKey{"x", "run"});
  *update.mutable_withdrawn(0)->mutable_b() = to_proto(SessionKey{"y", "run"});
  return update;
}

v1::TransformUpdate parsed(const std::string& page) {
  v1::ServerMessage message;
  EXPECT_TRUE(message.ParseFromString(page));
  return message.transform_update();
}

TEST(TransformPages, OneMessageWhileItFitsAndPagesBeyond) {
  const auto update = update_of(100);
  const std::size_t whole_bytes = transform_pages(update, 1000000).front().size();
  const auto fits = transform_pages(update, whole_bytes);
  ASSERT_EQ(fits.size(), 1U);
  EXPECT_EQ(parsed(fits[0]).pages(), 0U) << "as it was before there were pages";
  EXPECT_GT(transform_pages(update, whole_bytes - 1).size(), 1U);
}

TEST(TransformPages, HoldEverySessionOnceInOrderAndFitFrames) {
  constexpr std::size_t page_bytes = 16384;
  const auto update = update_of(5000);
  const auto pages = transform_pages(update, page_bytes);
  ASSERT_GT(pages.size(), 10U);
  v1::TransformUpdate joined;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    EXPECT_LT(pages[i].size(), page_bytes + 1024);
    const auto page = parsed(pages[i]);
    EXPECT_EQ(page.page(), i);
    EXPECT_EQ(page.pages(), pages.size());
    EXPECT_EQ(page.revision(), 7U);
    EXPECT_EQ(page.anchor().robot(), "robot 0");
    EXPECT_EQ(page.withdrawn_size(), i + 1 == pages.size() ? 1 : 0);
    joined.mutable_sessions()->MergeFrom(page.sessions());
  }
  v1::TransformUpdate wanted;
  *wanted.mutable_sessions() = update.sessions();
  EXPECT_EQ(joined.SerializeAsString(), wanted.SerializeAsString());
}

TEST(TransformPages, AnAcknowledgementWaitsForOnePageAtMost) {
  RobotOutbox outbox;
  const auto pages = std::make_shared<const TransformPages>(transform_pages(update_of(5000), 16384));
  outbox.update_transform(pages);
  std::size_t sent = 0;
  for (; sent < 3; ++sent) EXPECT_LT(outbox.take().size(), 20000U);
  outbox.acknowledge_keyframes(4);
  FrameReader reader;
  reader.feed(outbox.take());
  v1::ServerMessage first;
  ASSERT_TRUE(first.ParseFromString(**reader.next()));
  EXPECT_TRUE(first.has_keyframe_ack());
  for (++sent; !outbox.take().empty();) ++sent;
  EXPECT_EQ(sent, pages->size());
  outbox.update_transform(pages);
  (void)outbox.take();
  outbox.update_transform(std::make_shared<const TransformPages>(transform_pages(update_of(2, 8), 16384)));
  FrameReader newer;
  newer.feed(outbox.take());
  ASSERT_TRUE(first.ParseFromString(**newer.next()));
  EXPECT_EQ(first.transform_update().revision(), 8U) << "the rest of the older one is not sent";
  EXPECT_TRUE(outbox.take().empty());
}

}  // namespace
}  // namespace headframe
