// headframe-link-robot: one robot as a process of its own, to be killed. Goes on where its spool ends, stops when all
// of its keyframes and clouds are acknowledged.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tests/bench/link/drive.hpp"

int main(int argc, char** argv) {
  using namespace headframe;
  if (argc != 7)
    return std::fprintf(stderr,
                        "usage: headframe-link-robot ROBOT SPOOL HOST:PORT[,HOST:PORT] KEYFRAMES EVERY_MS ENROLMENT\n"),
           2;
  const std::string robot = argv[1];
  const auto servers = parse_peers(argv[3]);
  if (!servers) return std::fprintf(stderr, "%s\n", servers.error().message.c_str()), 2;
  const auto keyframes = static_cast<std::uint64_t>(std::atoll(argv[4]));
  auto config = bench::drive_config(robot, argv[2], servers->front().host, servers->front().port, argv[6]);
  config.more_servers.assign(servers->begin() + 1, servers->end());
  const auto client = RobotClient::open(config);
  if (!client) return std::fprintf(stderr, "%s\n", client.error().message.c_str()), 1;
  for (const auto& warning : (*client)->warnings()) std::printf("%s\n", warning.c_str());
  auto due = std::chrono::steady_clock::now();
  for (std::uint64_t i = (*client)->progress().keyframes + 1; i <= keyframes; ++i) {
    if (const auto added = bench::add_drive_keyframe(**client, robot, i); !added || !*added)
      return std::fprintf(stderr, "keyframe: %s\n", added ? "not new" : added.error().message.c_str()), 1;
    std::this_thread::sleep_until(due += std::chrono::milliseconds(std::atoi(argv[5])));
  }
  const auto done = (*client)->finish(std::chrono::seconds(120));
  if (!done) std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
