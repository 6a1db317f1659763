#include "tests/bench/link/audit.hpp"

#include <algorithm>
#include <csignal>
#include <memory>

#include "client/spool/spool.hpp"
#include "server/store/columns.hpp"
#include "server/store/postgres.hpp"
#include "server/store/sqlite.hpp"
#include "tests/bench/link/drive.hpp"

namespace headframe::bench {
namespace {

/// Everything of a keyframe that is stored, as one string.
std::string fingerprint(std::uint64_t sequence, double stamp_s, std::string_view pose, std::string_view q,
                        std::string_view w, std::string_view walls, std::int64_t points) {
  std::string out = std::to_string(sequence) + " " + std::to_string(stamp_s) + " " + std::to_string(points) + " ";
  return out.append(pose).append(q).append(w).append(walls);
}

std::string fingerprint(const Keyframe& k) {
  return fingerprint(k.sequence, k.stamp_s, pose_blob(k.T_local_sensor), floats_blob(k.descriptor.q),
                     floats_blob(k.descriptor.w), std::string(k.walls.code.begin(), k.walls.code.end()), k.point_count);
}

Result<Spool> open_spool(const std::string& robot, const std::filesystem::path& spool) {
  const auto config = drive_config(robot, spool, "127.0.0.1", 1);
  Hello hello;
  hello.session.robot = robot;
  hello.sensor = config.sensor;
  hello.family = {config.own_descriptors->family, config.own_descriptors->q_size, config.own_descriptors->w_size};
  hello.clouds = config.clouds;
  return Spool::open({spool, config.cloud_quota_bytes, false}, hello);
}

Result<std::unique_ptr<Database>> open_database(const std::filesystem::path& data, const std::string& url) {
  if (!url.empty()) {
    auto postgres = std::make_unique<PostgresDatabase>(url, url);
    if (auto connected = postgres->connect(); !connected) return tl::unexpected(connected.error());
    return postgres;
  }
  auto sqlite = SqliteDatabase::open((data / "headframe.db").string());
  if (!sqlite) return tl::unexpected(sqlite.error());
  return std::make_unique<SqliteDatabase>(std::move(*sqlite));
}

struct Stored {
  std::map<std::uint64_t, std::string> keyframes, clouds;
  std::uint64_t sessions = 0;
};

Result<Stored> read(Database& database, const std::string& robot) {
  Stored stored;
  auto done = database.each(
      "SELECT count(*) FROM sessions WHERE robot=?",
      [&](const Row& row) { stored.sessions = static_cast<std::uint64_t>(row.integer(0)); }, std::string_view(robot));
  if (done)
    done = database.each(
        "SELECT sequence, stamp_s, T_local_sensor, q, w, walls, point_count FROM keyframes JOIN sessions ON "
        "keyframes.session=sessions.id WHERE robot=?",
        [&](const Row& row) {
          const auto sequence = static_cast<std::uint64_t>(row.integer(0));
          stored.keyframes[sequence] =
              fingerprint(sequence, row.real(1), row.blob(2), row.blob(3), row.blob(4), row.blob(5), row.integer(6));
        },
        std::string_view(robot));
  if (done)
    done = database.each(
        "SELECT sequence, encoded FROM clouds JOIN sessions ON clouds.session=sessions.id WHERE robot=?",
        [&](const Row& row) { stored.clouds[static_cast<std::uint64_t>(row.integer(0))] = row.text(1); },
        std::string_view(robot));
  if (!done) return tl::unexpected(done.error());
  return stored;
}

Faults compare(const std::string& robot, const Stored& stored, const Produced& produced, const Told& told) {
  Faults faults;
  const auto fault = [&](std::uint64_t& count, const std::string& what) {
    ++count;
    if (faults.first.empty()) faults.first = robot + ": " + what;
  };
  if (stored.sessions > 1) fault(faults.duplicated, std::to_string(stored.sessions) + " sessions");
  std::uint64_t expected = 0;
  for (const auto& [sequence, content] : stored.keyframes) {
    const std::string name = "keyframe " + std::to_string(sequence);
    if (sequence != ++expected) fault(faults.corrupted, name + " follows a hole");
    if (sequence == 0 || sequence > produced.keyframes.size())
      fault(faults.duplicated, name + " was never produced");
    else if (content != produced.keyframes[sequence - 1])
      fault(faults.corrupted, name + " is not what was produced");
  }
  for (std::uint64_t s = 1; s <= told.keyframes; ++s)
    if (!stored.keyframes.contains(s)) fault(faults.lost, "keyframe " + std::to_string(s) + " was acknowledged");
  for (const auto& [sequence, bytes] : stored.clouds)
    if (sequence == 0 || sequence > produced.clouds.size() || bytes != produced.clouds[sequence - 1])
      fault(faults.clouds_corrupted, "cloud " + std::to_string(sequence) + " is not what was produced");
  for (const auto s : told.clouds)
    if (!stored.clouds.contains(s)) fault(faults.clouds_lost, "cloud " + std::to_string(s) + " was acknowledged");
  faults.keyframes = stored.keyframes.size();
  faults.clouds = stored.clouds.size();
  return faults;
}

}  // namespace

Result<Produced> produce(const std::string& robot, std::uint64_t keyframes, const std::filesystem::path& scratch) {
  auto config = drive_config(robot, scratch, "127.0.0.1", 1);
  config.sync = false;
  {
    const auto client = RobotClient::open(config);
    if (!client) return tl::unexpected(client.error());
    for (std::uint64_t i = 1; i <= keyframes; ++i)
      if (auto added = add_drive_keyframe(**client, robot, i); !added) return tl::unexpected(added.error());
  }
  const auto spool = open_spool(robot, scratch);
  if (!spool) return tl::unexpected(spool.error());
  Produced produced;
  for (std::uint64_t i = 1; i <= keyframes; ++i) {
    const auto keyframe = spool->keyframe(i);
    if (!keyframe) return tl::unexpected(keyframe.error());
    const auto sent = to_proto(*keyframe);  // poses turn by a last bit between message and matrix: as the server does
    const auto received = sent ? from_proto(*sent) : tl::unexpected(sent.error());
    if (!received) return tl::unexpected(received.error());
    produced.keyframes.push_back(fingerprint(*received));
    produced.clouds.push_back(spool->cloud(i).value_or(""));
  }
  return produced;
}

Result<Told> told(const std::string& robot, const std::filesystem::path& spool) {
  const auto opened = open_spool(robot, spool);
  if (!opened) return tl::unexpected(opened.error());
  Told told{opened->acknowledged_keyframes(), opened->last_sequence(), {}};
  for (std::uint64_t s = 1; s <= told.produced; ++s)
    if (!opened->holds_cloud(s)) told.clouds.insert(s);  // every keyframe has one, and the quota is out of reach
  return told;
}

Result<Told> told_so_far(const std::string& robot, const std::filesystem::path& spool, const test::Process& process,
                         const std::filesystem::path& copy) {
  namespace fs = std::filesystem;
  fs::remove_all(copy);
  process.signal(SIGSTOP);
  fs::create_directories(copy / "clouds");
  std::error_code gone;
  if (fs::exists(spool / "session.log")) fs::copy_file(spool / "session.log", copy / "session.log");
  for (const auto& cloud : fs::directory_iterator(spool / "clouds", gone))
    fs::create_hard_link(cloud.path(), copy / "clouds" / cloud.path().filename(), gone);
  process.signal(SIGCONT);
  return told(robot, copy);
}

Result<Faults> audit(const std::filesystem::path& data, const std::map<std::string, Produced>& produced,
                     const std::map<std::string, Told>& told, const std::string& url) {
  auto database = open_database(data, url);
  if (!database) return tl::unexpected(database.error());
  Faults faults;
  for (const auto& [robot, truth] : produced) {
    const auto stored = read(**database, robot);
    if (!stored) return tl::unexpected(stored.error());
    const auto it = told.find(robot);
    faults.add(compare(robot, *stored, truth, it == told.end() ? Told() : it->second));
  }
  return faults;
}

void Faults::add(const Faults& other) {
  lost += other.lost;
  duplicated += other.duplicated;
  corrupted += other.corrupted;
  clouds_corrupted += other.clouds_corrupted;
  clouds_lost += other.clouds_lost;
  keyframes += other.keyframes;
  clouds += other.clouds;
  if (first.empty()) first = other.first;
}

}  // namespace headframe::bench
