// The frame decoder: however the bytes are cut, the payloads are the same.
#include "common/wire/frame_codec.hpp"
#include "common/wire/limits.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace headframe::fuzz {
namespace {

struct Read {
  std::vector<std::string> payloads;
  bool failed = false;
};

Read read(std::string_view bytes, std::size_t step) {
  Read read;
  FrameReader reader;
  for (; !bytes.empty() && !read.failed; bytes.remove_prefix(std::min(step, bytes.size()))) {
    reader.feed(bytes.substr(0, step));
    while (true) {
      auto payload = reader.next();
      read.failed = !payload;
      if (!payload || !*payload) break;
      require(!(*payload)->empty() && (*payload)->size() <= limits::frame_bytes);
      read.payloads.push_back(std::move(**payload));
    }
  }
  return read;
}

}  // namespace
}  // namespace headframe::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  auto bytes = fuzz::text(data, size);
  const std::size_t step = std::size_t{fuzz::take_byte(bytes)} + 1;
  const auto whole = fuzz::read(bytes, bytes.size() + 1), cut = fuzz::read(bytes, step);
  fuzz::require(whole.payloads == cut.payloads && whole.failed == cut.failed);
  std::string again;
  for (const auto& payload : whole.payloads) fuzz::require(append_frame(again, payload).has_value());
  fuzz::require(bytes.substr(0, again.size()) == again);
  return 0;
}
