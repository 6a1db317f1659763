#include "tests/bench/localize.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <utility>

#include "common/descriptor/family.hpp"
#include "tests/bench/made_sets.hpp"
#include "tests/bench/measure.hpp"
#include "tests/bench/pipeline_run.hpp"

namespace headframe::bench {
namespace {

constexpr double right_m = 0.5, right_deg = 2, wrong_m = 1, wrong_deg = 3;
constexpr double on_the_map_m = 5;    // of the map's path: this rock is mapped
constexpr double off_the_map_m = 20;  // farther than this it is not
constexpr double settled_m = 10;      // of the newest path, on which the answer is measured

double path_m(const std::vector<Keyframe>& keyframes, std::size_t from, std::size_t to) {
  double metres = 0;
  for (std::size_t i = from + 1; i <= to; ++i)
    metres += (keyframes[i].T_local_sensor.translation() - keyframes[i - 1].T_local_sensor.translation()).norm();
  return metres;
}

/// Scan of each keyframe: the next whose pose is the keyframe's.
std::size_t scan_of(const DrivenSession& session, std::size_t keyframe) {
  const Eigen::Vector3d p = session.keyframes[keyframe].T_local_sensor.translation();
  std::size_t best = 0;
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < session.path.T_local_sensor.size(); ++i)
    if (const double d = (session.path.T_local_sensor[i].translation() - p).norm(); d < least) least = d, best = i;
  return best;
}

/// The drive from this keyframe on, in a frame of its own, as of a robot that wakes up there.
DrivenSession woken(const DrivenSession& whole, std::size_t first, std::size_t last) {
  DrivenSession out{.name = whole.name, .world = whole.world, .family = whole.family};
  const Pose T_first = whole.keyframes[first].T_local_sensor;
  const Pose T_whole_woken =
      Eigen::Translation3d(T_first.translation()) * Eigen::AngleAxisd(yaw_rad(T_first), Eigen::Vector3d::UnitZ());
  for (std::size_t i = first; i <= last; ++i) {
    out.keyframes.push_back(whole.keyframes[i]);
    out.keyframes.back().sequence = out.keyframes.size();
    out.keyframes.back().T_local_sensor = T_whole_woken.inverse() * whole.keyframes[i].T_local_sensor;
    out.clouds.push_back(whole.clouds[i]);
  }
  for (std::size_t i = scan_of(whole, first); i <= scan_of(whole, last); ++i) {
    out.path.T_local_sensor.push_back(T_whole_woken.inverse() * whole.path.T_local_sensor[i]);
    out.path.T_world_sensor.push_back(whole.path.T_world_sensor[i]);
  }
  return out;
}

double nearest_m(const test::TruePath& map, const Eigen::Vector3d& p_world) {
  double least = std::numeric_limits<double>::max();
  for (const Pose& T : map.T_world_sensor) least = std::min(least, (T.translation() - p_world).norm());
  return least;
}

enum class Rock { mapped, edge, unmapped };
constexpr const char* names[] = {"mapped", "edge", "unmapped"};

Rock rock_of(const test::TruePath& map, const test::TruePath& woken) {
  std::size_t on = 0, off = 0;
  for (const Pose& T : woken.T_world_sensor) {
    const double d = nearest_m(map, T.translation());
    on += d <= on_the_map_m ? 1 : 0;
    off += d >= off_the_map_m ? 1 : 0;
  }
  if (on == woken.T_world_sensor.size()) return Rock::mapped;
  return off == woken.T_world_sensor.size() ? Rock::unmapped : Rock::edge;
}

test::OverlapError error_now(const test::TruePath& map, const test::TruePath& woken, std::size_t scans,
                             const Pose& T_map_woken) {
  test::TruePath tail;
  constexpr double near_m =
      8;  // or where the paths come nearest: a robot may look into rock that the map saw from farther off
  const auto& local = woken.T_local_sensor;
  for (std::size_t i = scans; i-- > 0;) {
    if ((local[i].translation() - local[scans - 1].translation()).norm() > settled_m) break;
    tail.T_local_sensor.push_back(local[i]);
    tail.T_world_sensor.push_back(woken.T_world_sensor[i]);
  }
  double least_m = std::numeric_limits<double>::max();
  for (const Pose& T : tail.T_world_sensor) least_m = std::min(least_m, nearest_m(map, T.translation()));
  return overlap_error(map, tail, T_map_woken, std::max(near_m, least_m + 4));
}

struct Try {
  Rock rock = Rock::edge;
  double first_m = -1;  // path until the first answer; -1: none
  bool right = false, wrong = false;
  double te_m = -1, re_deg = -1;  // of the last answer
  std::vector<double> ms;         // of every question
};

class Asker {
 public:
  Asker(const LocalizeBench& bench) : bench_(bench), csv_(bench.out / "localize.csv") {
    csv_ << "map,woken,start,rock,driven_m,found,te_m,re_deg,ms,best_te_m,best_re_deg";
    for (const auto& field : evidence_fields()) csv_ << ',' << field.name;
    csv_ << "\n";
  }

  /// From starts spread over each kind of rock: as many where all of the way is mapped, and where nothing of it is;
  /// half as many at the edge.
  void ask_along(const DrivenSession& map, const DrivenSession& drive) {
    std::map<Rock, std::vector<std::pair<std::size_t, std::size_t>>> stretches;
    for (std::size_t first = 0, last = 0; first < drive.keyframes.size(); ++first) {
      while (last + 1 < drive.keyframes.size() && path_m(drive.keyframes, first, last) < bench_.driven_m) ++last;
      const double driven_m = path_m(drive.keyframes, first, last);
      if (driven_m < bench_.driven_m || driven_m > 1.5 * bench_.driven_m) continue;
      stretches[rock_of(map.path, woken(drive, first, last).path)].emplace_back(first, last);
    }
    PipelineRun run;
    run.add(map);
    run.take_as_tried();
    for (const auto& [rock, of_rock] : stretches) {
      const auto asked = static_cast<std::size_t>(rock == Rock::edge ? (bench_.starts + 1) / 2 : bench_.starts);
      const std::size_t step = std::max<std::size_t>(1, of_rock.size() / asked);
      for (std::size_t i = step / 2; i < of_rock.size() && i < asked * step; i += step)
        tries_.push_back(ask(run, map, woken(drive, of_rock[i].first, of_rock[i].second)));
    }
  }

  const std::vector<Try>& tries() const { return tries_; }

 private:
  Try ask(PipelineRun& run, const DrivenSession& map, const DrivenSession& robot) {
    Try out;
    out.rock = rock_of(map.path, robot.path);
    const SessionId id = run.begin(robot);
    if (!bench_.rests) run.pipeline.ask_where(id, true);
    double asked_m = 0;
    for (std::size_t i = 0; i < robot.keyframes.size(); ++i) {
      run.add_keyframe(id, i);
      const double driven_m = path_m(robot.keyframes, 0, i);
      if (i + 1 < robot.keyframes.size() && driven_m < asked_m + bench_.step_m) continue;
      asked_m = driven_m;
      if (bench_.rests) run.pipeline.complete_session(id);
      out.ms.push_back(wall_ms([&] { run.attempt(id); }));
      const SessionLocalization told = bench_.rests ? merged(run, id) : run.pipeline.localization(id);
      const std::size_t scans = scan_of(robot, i) + 1;
      test::OverlapError error;
      if (told.found) {
        error = error_now(map.path, robot.path, scans, told.T_component_session);
        if (out.first_m < 0) out.first_m = driven_m;
        out.te_m = error.translation_m;
        out.re_deg = error.rotation_deg;
        out.right = error.pairs > 0 && error.translation_m < right_m && error.rotation_deg < right_deg;
        out.wrong = out.wrong || error.pairs == 0 || error.translation_m > wrong_m || error.rotation_deg > wrong_deg;
      } else {
        out.right = false;
      }
      note(run, map, robot, out, driven_m, told.found, error, scans, id);
    }
    run.pipeline.set_aside(id);
    return out;
  }

  /// What everybody is told.
  static SessionLocalization merged(const PipelineRun& run, SessionId id) {
    SessionLocalization out;
    for (const Alignment& k : run.pipeline.alignments()) {
      if (k.b != id || k.state != AlignmentState::published) continue;
      out.found = true;
      out.T_component_session = k.T_a_b;
    }
    return out;
  }

  void note(const PipelineRun& run, const DrivenSession& map, const DrivenSession& robot, const Try& now,
            double driven_m, bool found, const test::OverlapError& error, std::size_t scans, SessionId id) {
    Evidence evidence;
    test::OverlapError best;
    for (const Alignment& k : run.pipeline.alignments()) {
      if (k.b != id) continue;
      evidence = k.evidence;
      best = error_now(map.path, robot.path, scans, k.T_a_b);
    }
    csv_ << map.name << ',' << robot.name << ',' << id << ',' << names[static_cast<int>(now.rock)] << ',' << driven_m
         << ',' << found << ',' << error.translation_m << ',' << error.rotation_deg << ',' << now.ms.back() << ','
         << best.translation_m << ',' << best.rotation_deg;
    for (const auto& field : evidence_fields()) csv_ << ',' << evidence.*field.member;
    csv_ << std::endl;
  }

  const LocalizeBench& bench_;
  std::ofstream csv_;
  std::vector<Try> tries_;
};

nlohmann::json summed_up(const std::vector<Try>& tries) {
  nlohmann::json out;
  std::vector<double> ms;
  std::printf("localize: %zu starts\n  %-10s %6s %6s %7s %6s %10s %8s %8s\n", tries.size(), "", "starts", "right",
              "inexact", "wrong", "unanswered", "p50 m", "error m");
  for (const Rock rock : {Rock::mapped, Rock::edge, Rock::unmapped}) {
    int starts = 0, right = 0, wrong = 0, unanswered = 0;
    std::vector<double> first_m, te_m;
    for (const Try& t : tries) {
      if (rock == Rock::mapped) ms.insert(ms.end(), t.ms.begin(), t.ms.end());
      if (t.rock != rock) continue;
      ++starts;
      wrong += t.wrong;
      right += t.right && !t.wrong;
      unanswered += t.first_m < 0;
      if (t.first_m >= 0) first_m.push_back(t.first_m);
      if (t.te_m >= 0) te_m.push_back(t.te_m);
    }
    const char* name = names[static_cast<int>(rock)];
    out[name] = {{"starts", starts},
                 {"right", right},
                 {"wrong", wrong},
                 {"unanswered", unanswered},
                 {"first_p50_m", quantile(first_m, 0.5)},
                 {"error_p50_m", quantile(te_m, 0.5)}};
    std::printf("  %-10s %6d %6d %7d %6d %10d %8.1f %8.2f\n", name, starts, right, starts - right - wrong - unanswered,
                wrong, unanswered, quantile(first_m, 0.5), quantile(te_m, 0.5));
  }
  out["question_p50_ms"] = quantile(ms, 0.5);
  out["question_p95_ms"] = quantile(ms, 0.95);
  std::printf("  a question: p50 %.0f ms, p95 %.0f ms\n", quantile(ms, 0.5), quantile(ms, 0.95));
  return out;
}

/// Of the data sets through one world, each as maps for its own drives and for those of the next set.
void ask_in_world(const std::vector<std::filesystem::path>& sets, const std::string& kind, Asker& asker) {
  const auto read = [&](std::size_t i) {
    auto sessions = sessions_of(sets[i % sets.size()], {std::string(default_family_name)});
    for (auto& [robot, session] : sessions) session.world = kind;
    return sessions;
  };
  auto maps = read(0);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    auto next = read(i + 1);
    for (const auto& [robot, map] : maps) {
      for (const auto& [other, drive] : maps)
        if (other != robot) asker.ask_along(map, drive);
      for (const auto& [other, drive] : next)
        if (other == robot && sets.size() > 1) asker.ask_along(map, drive);
    }
    maps = std::move(next);
    std::fprintf(stderr, "\r%s: set %zu of %zu, %zu starts   ", kind.c_str(), i + 1, sets.size(), asker.tries().size());
  }
}

}  // namespace

nlohmann::json localize(const LocalizeBench& bench) {
  std::map<std::string, std::vector<std::filesystem::path>> by_kind;
  for (const auto& set : sets_below(bench.sets)) by_kind[kind_of(set.filename())].push_back(set);
  Asker asker(bench);
  for (const auto& [kind, sets] : by_kind) ask_in_world(sets, kind, asker);
  std::fprintf(stderr, "\n");
  return summed_up(asker.tries());
}

}  // namespace headframe::bench
