#include <gtest/gtest.h>

#include "common/wire/frame_codec.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

TEST(FrameCodec, PayloadsComeBackHoweverTheStreamIsCut) {
  std::string stream;
  const std::vector<std::string> payloads{"a", std::string(1000, 'b'), std::string(limits::frame_bytes, 'c')};
  for (const auto& p : payloads) ASSERT_TRUE(append_frame(stream, p));
  for (std::size_t cut : {1U, 3U, 7U, 4096U, 1000000U}) {
    FrameReader reader;
    std::vector<std::string> read;
    for (std::size_t at = 0; at < stream.size(); at += cut) {
      reader.feed(std::string_view(stream).substr(at, cut));
      while (true) {
        const auto payload = reader.next();
        ASSERT_TRUE(payload);
        if (!*payload) break;
        read.push_back(**payload);
      }
    }
    EXPECT_EQ(read, payloads) << "cut every " << cut;
  }
}

TEST(FrameCodec, LengthIsCheckedBeforeThePayloadComes) {
  for (const std::string& header : {std::string("\xff\xff\xff\xff", 4), std::string("GET "), std::string(4, '\0'),
                                    std::string("\x00\x04\x00\x01", 4)}) {
    FrameReader reader;
    reader.feed(header);
    EXPECT_FALSE(reader.next());
    EXPECT_FALSE(reader.next()) << "an unreadable stream stays unreadable";
  }
  FrameReader reader;
  reader.feed(std::string_view("\x00\x04\x00\x00", 4));  // exactly the limit
  EXPECT_TRUE(reader.next());
}

TEST(FrameCodec, RefusesToSendWhatThePeerWouldRefuse) {
  std::string out;
  EXPECT_FALSE(append_frame(out, ""));
  EXPECT_FALSE(append_frame(out, std::string(limits::frame_bytes + 1, 'x')));
  EXPECT_TRUE(out.empty());
}

}  // namespace
}  // namespace headframe
