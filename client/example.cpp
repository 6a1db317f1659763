// The smallest robot: build/release/bin/headframe-example SESSION_DIR HOST [ENROLMENT]
#include <cstdio>

#include "client/robot_client.hpp"
#include "common/dataset/session_folder.hpp"

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) return 2;
  const auto recording = headframe::SessionFolder::open(argv[1]);
  if (!recording) return std::fprintf(stderr, "%s\n", recording.error().message.c_str()), 1;

  headframe::RobotConfig config;
  config.robot = "example";
  config.spool = "example-spool";
  config.host = argv[2];
  if (argc == 4) config.enrolment = argv[3];  // what `headframe robot add example` printed; needed once
  config.sensor = recording->sensor();
  const auto robot = headframe::RobotClient::open(config);
  if (!robot) return std::fprintf(stderr, "%s\n", robot.error().message.c_str()), 1;

  (*robot)->on_transform([](const headframe::Transforms& t) {
    std::printf("revision %llu places %zu sessions\n", static_cast<unsigned long long>(t.revision), t.sessions.size());
  });
  for (std::size_t i = 0; i < recording->size(); ++i)
    if (const auto scan = recording->load(i))
      if (const auto added =
              (*robot)->add_scan(recording->stamp_s(i), recording->T_local_sensor(i), scan->points, scan->intensity);
          !added)
        std::fprintf(stderr, "scan %zu: %s\n", i, added.error().message.c_str());

  const auto done = (*robot)->finish(std::chrono::seconds(30));
  if (!done) std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
