#include "server/net/transform_pages.hpp"

namespace headframe {
namespace {

std::string message_of(v1::TransformUpdate update) {
  v1::ServerMessage message;
  *message.mutable_transform_update() = std::move(update);
  return message.SerializeAsString();
}

}  // namespace

TransformPages transform_pages(const v1::TransformUpdate& update, std::size_t page_bytes) {
  if (std::string whole = message_of(update); whole.size() <= page_bytes) return {std::move(whole)};
  constexpr std::size_t around_session_bytes = 4;  // its tag and length
  v1::TransformUpdate without_sessions = update;
  without_sessions.clear_sessions();
  const std::size_t frame_of_page_bytes = without_sessions.ByteSizeLong();
  std::vector<v1::TransformUpdate> pages;
  std::size_t filled = page_bytes;
  for (const v1::SessionTransform& session : update.sessions()) {
    if (filled >= page_bytes) {
      auto& page = pages.emplace_back();
      page.set_revision(update.revision());
      page.set_component(update.component());
      *page.mutable_anchor() = update.anchor();
      page.set_page(static_cast<std::uint32_t>(pages.size()) - 1);
      filled = frame_of_page_bytes;
    }
    *pages.back().add_sessions() = session;
    filled += session.ByteSizeLong() + around_session_bytes;
  }
  *pages.back().mutable_provisional() = update.provisional();
  *pages.back().mutable_withdrawn() = update.withdrawn();
  TransformPages out;
  for (v1::TransformUpdate& page : pages) {
    page.set_pages(static_cast<std::uint32_t>(pages.size()));
    out.push_back(message_of(std::move(page)));
  }
  return out;
}

}  // namespace headframe
