// Each hostile peer is refused and said once, and a robot beside it does not notice. How little it notices is measured
// by
// `./run bench link hostile`.
#include "tests/support/hostile_peers.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>

#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"
#include "server/map_merge_server.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

/// The log's warnings and errors while it lives.
class Warnings {
 public:
  Warnings() : before_(spdlog::default_logger()) {
    auto logger = std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_));
    logger->set_level(spdlog::level::warn);
    spdlog::set_default_logger(logger);
  }
  ~Warnings() { spdlog::set_default_logger(before_); }
  Warnings(const Warnings&) = delete;
  Warnings& operator=(const Warnings&) = delete;

  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

TEST(HostilePeers, AreRefusedAndLoggedOnceAndNobodyElseNotices) {
  const TempDir folder;
  ServerConfig config;
  config.limits.hello_s = 1;
  auto server = MapMergeServer::start({folder.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, config});
  ASSERT_TRUE(server) << server.error().message;
  const auto code_of = [&](const std::string& robot) {
    return bench::enrolment(to_string((*server)->http()), folder.path() / "data", robot).value();
  };
  const auto good = RobotClient::open(
      bench::drive_config("good", folder.path() / "spool", "127.0.0.1", (*server)->robots().port, code_of("good")));
  ASSERT_TRUE(good) << good.error().message;
  const test::HostileTarget target{(*server)->robots(), "good", "bad", random_secret(token_bytes),
                                   parse_enrolment(code_of("bad"))->code};
  test::enrol_accomplice(target);
  std::uint64_t keyframes = 0;
  const auto good_goes_on = [&] {
    EXPECT_TRUE(bench::add_drive_keyframe(**good, "good", ++keyframes).value());
    for (int i = 0; i < 1000 && (*good)->progress().keyframes_acknowledged < keyframes; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ((*good)->progress().keyframes_acknowledged, keyframes);
    EXPECT_EQ((*good)->progress().link_error, "");
  };
  good_goes_on();
  for (const auto& peer : test::hostile_peers()) {
    std::string said;
    {
      const Warnings warnings;
      const std::string answer = peer.attack(target);
      EXPECT_NE(answer.find(peer.answer), std::string::npos) << peer.name << ": " << answer;
      good_goes_on();  // what was said to the peer was written to the log before this
      said = warnings.text();
    }
    const std::string words = peer.answer;
    if (words.empty()) continue;  // a flood fills no log
    const auto first = said.find(words);
    EXPECT_NE(first, std::string::npos) << peer.name << " is not in the log: " << said;
    EXPECT_EQ(said.find(words, first + 1), std::string::npos) << peer.name << " is in the log twice: " << said;
    EXPECT_EQ(said.find(to_hex(target.token)), std::string::npos);
  }
}

}  // namespace
}  // namespace headframe
