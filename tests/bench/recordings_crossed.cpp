#include <cstdio>
#include <numbers>

#include "tests/bench/merges.hpp"
#include "tests/bench/pipeline_run.hpp"
#include "tests/bench/verdict_rows.hpp"
#include "tests/mine/random.hpp"

namespace headframe::bench {
namespace {

struct Set {
  const char* name;
  std::vector<const char*> robots;
};

/// tunnel-four and tunnel-apart share a world.
std::string world_of(const std::string& set) {
  return set.starts_with("tunnel-four") || set.starts_with("tunnel-apart") ? "tunnel" : set;
}

bool truly_near(const DrivenSession& a, const DrivenSession& b) {
  if (a.world != b.world) return false;
  return overlap_error(a.path, b.path, Pose::Identity()).pairs > 0;
}

std::vector<DrivenSession> read_sessions(const std::filesystem::path& recordings) {
  const std::vector<Set> sets{{"nclt-two-robots", {"a", "b"}},
                              {"tunnel-two", {"r1", "r2"}},
                              {"tunnel-four", {"s1", "s2", "s3", "s4"}},
                              {"tunnel-apart", {"r1", "r2"}}};
  const auto family = make_family(default_family_name).value();
  std::vector<DrivenSession> sessions;
  for (const Set& set : sets)
    for (const char* robot : set.robots)
      if (std::filesystem::exists(recordings / set.name / robot)) {
        sessions.push_back(read_driven_session(recordings / set.name, robot, *family));
        sessions.back().world = world_of(sessions.back().world);
      }
  return sessions;
}

/// The session in a frame that is turned by yaw_rad: what the robot's first heading was is chance.
void turn(DrivenSession& session, double yaw_rad) {
  const Pose T = pose_from_yaw(yaw_rad, Eigen::Vector3d::Zero());
  for (Keyframe& k : session.keyframes) k.T_local_sensor = T * k.T_local_sensor;
  for (Pose& p : session.path.T_local_sensor) p = T * p;
}

/// One keyframe in twenty sees nothing but noise.
void spoil(DrivenSession& session, mine::Rng rng) {
  const auto noise = [&](std::vector<float>& v) {
    for (float& f : v) f = static_cast<float>(rng.normal());
  };
  for (std::size_t i = 10; i < session.keyframes.size(); i += 20) {
    Keyframe& k = session.keyframes[i];
    noise(k.descriptor.q);
    noise(k.descriptor.w);
    for (auto& code : k.walls.code) code = static_cast<std::uint8_t>(rng.index(255));
    for (Sweep& sweep : session.clouds[i].sweeps)
      for (auto& p : sweep.points)
        p = Eigen::Vector3d(rng.uniform(-15, 15), rng.uniform(-15, 15), rng.uniform(-2, 3)).cast<float>();
  }
}

nlohmann::json judged(const std::vector<DrivenSession>& sessions, const char* how, VerdictRows& rows) {
  PipelineRun run;
  for (const DrivenSession& s : sessions) run.add(s);
  const auto count = static_cast<SessionId>(sessions.size());
  for (SessionId id = 1; id <= count; ++id) run.attempt(id);
  rows.add(run);
  std::printf(
      "recordings %s, all pairs of %zu sessions: state, p, runner-up, violations, misfit, shared path, aliases, "
      "descriptors, error\n",
      how, sessions.size());
  nlohmann::json out{{"false", 0}, {"true_pairs", 0}, {"merged", 0}};
  for (const Alignment& k : run.pipeline.alignments()) {
    const DrivenSession &a = run.session(k.a), &b = run.session(k.b);
    const bool near = truly_near(a, b);
    const Outcome outcome = judge_outcome(run, k.a, k.b);
    const Evidence& e = k.evidence;
    out["true_pairs"] = out["true_pairs"].get<int>() + near;
    out["merged"] = out["merged"].get<int>() + outcome.right;
    out["false"] = out["false"].get<int>() + (outcome.merged && !outcome.right);
    const auto error = near ? overlap_error(a.path, b.path, k.T_a_b) : test::OverlapError{};
    if (near || e.probability > 0.01)
      std::printf("  %-20s %-20s %-9s %.3f %.3f  %.4f %.3f m %4.0f m %2.0f %.2f  %s %.3f m %.2f deg\n", a.name.c_str(),
                  b.name.c_str(), std::string(to_string(k.state)).c_str(), e.probability, e.runner_up,
                  e.freespace_violation, e.residual_m, e.overlap_m, e.aliases, e.descriptors_alike,
                  near ? "true pair" : "-", error.translation_m, error.rotation_deg);
  }
  std::printf("  %d true pairs, %d merged rightly, %d false\n", out["true_pairs"].get<int>(), out["merged"].get<int>(),
              out["false"].get<int>());
  return out;
}

}  // namespace

nlohmann::json recordings_crossed(const std::filesystem::path& recordings, const std::filesystem::path& out_folder) {
  auto sessions = read_sessions(recordings);
  if (sessions.empty()) {
    std::fprintf(stderr, "headframe-bench: no recordings in %s; name the folder that holds them\n", recordings.c_str());
    return nullptr;
  }
  VerdictRows rows(out_folder / "verdict_recordings.csv");
  nlohmann::json out = judged(sessions, "as they are", rows);
  mine::Rng rng(1);
  for (DrivenSession& s : sessions) turn(s, rng.uniform(-std::numbers::pi, std::numbers::pi));
  out["turned"] = judged(sessions, "with each frame turned", rows);
  for (DrivenSession& s : sessions) spoil(s, rng.fork(s.keyframes.size()));
  out["turned_and_spoiled"] = judged(sessions, "turned, and 5 % of the keyframes noise", rows);
  return out;
}

}  // namespace headframe::bench
