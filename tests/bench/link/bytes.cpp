#include <chrono>
#include <cstdio>
#include <thread>

#include "common/cloud/cloud_codec.hpp"
#include "server/map_merge_server.hpp"
#include "tests/bench/link/drive.hpp"
#include "tests/bench/link/enrol.hpp"
#include "tests/bench/link/link.hpp"
#include "tests/bench/link/seconds_since.hpp"
#include "tests/support/base_station.hpp"
#include "tests/support/box_mine.hpp"
#include "tests/support/faulty_proxy.hpp"

namespace headframe::bench {
namespace {

/// Adds keyframes one by one, each when the one before is acknowledged, and gives the mean of the bytes that went to
/// the server for each, TLS and answers to pings included; TCP and IP headers (some 52 bytes a packet) are not.
Result<double> wire_bytes_per_keyframe(const std::vector<Keyframe>& keyframes) {
  const test::ScratchFolder scratch;
  auto server = MapMergeServer::start({scratch.path() / "data", {"127.0.0.1", 0}, {"127.0.0.1", 0}, {}});
  if (!server) return tl::unexpected(server.error());
  const auto enrolled = enrolment(to_string((*server)->http()), scratch.path() / "data", "ant");
  if (!enrolled) return tl::unexpected(enrolled.error());
  const test::FaultyProxy proxy((*server)->robots().port, {1, 0, 0});
  auto config = drive_config("ant", scratch.path() / "spool", "127.0.0.1", proxy.port(), *enrolled);
  const Descriptor& first = keyframes.front().descriptor;
  config.own_descriptors = OwnDescriptors{{std::string(default_family_name), 1}, first.q.size(), first.w.size()};
  config.clouds = CloudPolicy::never;
  const auto robot = RobotClient::open(config);
  if (!robot) return tl::unexpected(robot.error());
  std::uint64_t before = 0;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const Keyframe& k = keyframes[i];
    if (auto added = (*robot)->add_keyframe(k.stamp_s, k.T_local_sensor, k.descriptor, {}); !added)
      return tl::unexpected(added.error());
    const auto start = Clock::now();
    while ((*robot)->progress().keyframes_acknowledged <= i) {
      if (Clock::now() - start > std::chrono::seconds(10))
        return failure(ErrorCode::unavailable, (*robot)->progress().link_error);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (i == 0) before = proxy.bytes_to_server();  // with the handshake
  }
  return static_cast<double>(proxy.bytes_to_server() - before) / static_cast<double>(keyframes.size() - 1);
}

struct Coding {
  double bytes = 0, points = 0, encode_s = 0, decode_s = 0;

  void add(const KeyframeCloud& cloud) {
    const auto start = Clock::now();
    const auto encoded = encode_cloud(cloud).value();
    const auto between = Clock::now();
    (void)decode_cloud(encoded).value();
    encode_s += std::chrono::duration<double>(between - start).count();
    decode_s += std::chrono::duration<double>(Clock::now() - between).count();
    bytes += static_cast<double>(encoded.size());
    points += static_cast<double>(point_count(cloud));
  }
  double per_point() const { return bytes / points; }
  double encode_ns() const { return encode_s / points * 1e9; }
  double decode_ns() const { return decode_s / points * 1e9; }
};

}  // namespace

nlohmann::json link_bytes() {
  const test::BoxMine mine({test::BoxMine::drift(0, 0, 80, 0), test::BoxMine::drift(30, 0, 30, 40)});
  const auto drive = test::drive(mine, {{2, 0}, {30, 0}, {30, 38}}, 0, 1);
  Coding coding;
  for (const KeyframeCloud& cloud : drive.clouds) coding.add(cloud);
  const auto per_keyframe = wire_bytes_per_keyframe(drive.keyframes);
  if (!per_keyframe)
    return std::fprintf(stderr, "link bytes: %s\n", per_keyframe.error().message.c_str()), nlohmann::json();
  std::printf(
      "link bytes\n  %.0f bytes a keyframe on the wire, with TLS; clouds %.2f bytes a point at 1 cm, coded in %.0f ns "
      "and read in %.0f ns a point\n",
      *per_keyframe, coding.per_point(), coding.encode_ns(), coding.decode_ns());
  return {{"bytes_per_keyframe", *per_keyframe},
          {"bytes_per_point", coding.per_point()},
          {"encode_ns_per_point", coding.encode_ns()},
          {"decode_ns_per_point", coding.decode_ns()}};
}

}  // namespace headframe::bench
