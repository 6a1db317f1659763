#include "tests/bench/pose_graph.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/descriptor/family.hpp"
#include "server/merge/loop_closures.hpp"
#include "server/picture/top_view.hpp"
#include "tests/bench/made_sets.hpp"
#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

/// A keyframe of a component: where it is, and where it lies by what is believed.
struct PlacedKeyframe {
  SessionId session = 0;
  Pose truth, before, after;
};
using Placed = std::vector<PlacedKeyframe>;
using Believed = Pose PlacedKeyframe::*;

struct Errors {
  double before_m = 0, after_m = 0;  // root mean square
};

/// True poses of the keyframes: the scans that stand where they say.
std::vector<Pose> true_keyframes(const DrivenSession& session) {
  std::vector<Pose> out;
  std::size_t scan = 0;
  for (const Keyframe& keyframe : session.keyframes) {
    double nearest = std::numeric_limits<double>::max();
    std::size_t best = scan;
    for (std::size_t i = scan; i < session.path.T_local_sensor.size(); ++i) {
      const double m = (session.path.T_local_sensor[i].translation() - keyframe.T_local_sensor.translation()).norm();
      if (m < nearest) nearest = m, best = i;
      if (m < 1e-3) break;
    }
    scan = best;
    out.push_back(session.path.T_world_sensor.at(best));
  }
  return out;
}

/// After the rigid transform that lays the estimate on the truth best: a component's frame is nobody's fault.
double rms_m(const Placed& placed, Believed believed) {
  Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(placed.size())), to = from;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = (placed[i].*believed).translation();
    to.col(static_cast<Eigen::Index>(i)) = placed[i].truth.translation();
  }
  const Eigen::Isometry3d T(Eigen::umeyama(from, to, false));
  return std::sqrt(((T * from) - to).colwise().squaredNorm().mean());
}

/// Of keyframes of two sessions that stand near each other: how far apart the same rock lies in the map.
double between_m(const Placed& placed, Believed believed) {
  constexpr double near_m = 8;
  double sum = 0;
  std::size_t count = 0;
  for (const PlacedKeyframe& a : placed)
    for (const PlacedKeyframe& b : placed) {
      if (a.session >= b.session || (a.truth.translation() - b.truth.translation()).norm() > near_m) continue;
      sum += ((a.*believed).inverse() * (b.*believed).translation() - a.truth.inverse() * b.truth.translation())
                 .squaredNorm();
      ++count;
    }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

Placed placed(const PipelineRun& run, const Component& component) {
  Placed out;
  for (const Placement& p : component.placements) {
    const DrivenSession& session = run.session(p.session);
    const std::vector<Pose> truth = true_keyframes(session);
    const auto correction = run.pipeline.corrections().find(p.session);
    for (std::size_t i = 0; i < session.keyframes.size(); ++i) {
      const Keyframe& k = session.keyframes[i];
      const Pose before = p.T_component_session * k.T_local_sensor;
      const bool bent = correction != run.pipeline.corrections().end();
      out.push_back(
          {p.session, truth[i], before, bent ? correction->second->corrected(k.sequence, k.T_local_sensor) : before});
    }
  }
  return out;
}

picture::Panel panel(const std::string& title, const PipelineRun& run, const Placed& placed, Believed believed) {
  picture::Panel out{title, {}};
  std::size_t i = 0;
  for (const PlacedKeyframe& k : placed) {
    if (i > 0 && (&k - 1)->session != k.session) i = 0;
    if (i == 0) out.layers.emplace_back().colour = picture::colour_of(static_cast<std::size_t>(k.session - 1));
    picture::Layer& layer = out.layers.back();
    const Pose& T = k.*believed;
    layer.trajectory.emplace_back(T.translation());
    for (const Sweep& sweep : run.session(k.session).clouds[i++].sweeps)
      for (const Eigen::Vector3f& point : sweep.points)
        if (std::abs(point.z()) < 1) layer.points.push_back(T.cast<float>() * point);
  }
  return out;
}

/// Within reach of loop closures, in truth.
std::size_t keyframes_that_come_back(const DrivenSession& session) {
  const LoopClosureRules rules;
  const std::vector<Pose> truth = true_keyframes(session);
  std::vector<double> path_to_m(truth.size(), 0);
  std::size_t count = 0;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    path_to_m[i] = path_to_m[i - 1] + (truth[i].translation() - truth[i - 1].translation()).norm();
    for (std::size_t k = 0; path_to_m[i] - path_to_m[k] >= rules.apart_m; ++k) {
      if ((truth[i].translation() - truth[k].translation()).norm() > rules.near_m) continue;
      ++count;
      break;
    }
  }
  return count;
}

class Report {
 public:
  explicit Report(std::filesystem::path out) : out_(std::move(out)) {}

  /// Merges the sessions and compares. loop: it is one, and is drawn.
  void add(const std::string& name, const std::vector<DrivenSession>& sessions, bool loop) {
    if (sessions.empty()) return;
    PipelineRun run;
    for (const DrivenSession& session : sessions) run.add(session);
    StageTimes times;
    for (std::size_t i = 0; i < sessions.size(); ++i) times += run.attempt(static_cast<SessionId>(i + 1));
    for (const Component& component : run.pipeline.atlas().components) {
      const bool bent = run.pipeline.corrections().contains(component.id);
      if (!bent && component.placements.size() < 2) {
        if (loop)
          std::printf("  %-44s no loop was found; %zu keyframes come back near the path\n", name.c_str(),
                      keyframes_that_come_back(run.session(component.id)));
        continue;
      }
      const Placed all = placed(run, component);
      const Errors e{rms_m(all, &PlacedKeyframe::before), rms_m(all, &PlacedKeyframe::after)};
      const Errors between{between_m(all, &PlacedKeyframe::before), between_m(all, &PlacedKeyframe::after)};
      std::printf("  %-44s %2zu sessions %4zu keyframes   %.3f m -> %.3f m   between sessions %.3f m -> %.3f m%s\n",
                  name.c_str(), component.placements.size(), all.size(), e.before_m, e.after_m, between.before_m,
                  between.after_m, e.after_m > e.before_m + 0.01 ? "   WORSE" : "");
      std::fflush(stdout);
      rows_.push_back({{"name", name},
                       {"loop", loop},
                       {"before_m", e.before_m},
                       {"after_m", e.after_m},
                       {"between_before_m", between.before_m},
                       {"between_after_m", between.after_m}});
      worst_increase_m_ = std::max(worst_increase_m_, e.after_m - e.before_m);
      if (!loop) continue;
      before_ += e.before_m, after_ += e.after_m;
      std::string file = name;
      std::replace_if(
          file.begin(), file.end(), [](char c) { return c == ' ' || c == '/' || c == ','; }, '-');
      (void)picture::write_png({"A loop before and after the pose graph",
                                name,
                                {panel("one rigid transform a session", run, all, &PlacedKeyframe::before),
                                 panel("pose graph", run, all, &PlacedKeyframe::after)},
                                {}},
                               out_ / (file + ".png"));
    }
  }

  nlohmann::json figures() const {
    const double ratio = before_ > 0 ? after_ / before_ : 1;
    std::printf("  loops: error after / before %.2f; nowhere worse by more than %.3f m\n", ratio,
                std::max(0.0, worst_increase_m_));
    return {{"loop_error_ratio", ratio}, {"worst_increase_m", worst_increase_m_}, {"rows", rows_}};
  }

 private:
  std::filesystem::path out_;
  nlohmann::json rows_ = nlohmann::json::array();
  double before_ = 0, after_ = 0, worst_increase_m_ = -std::numeric_limits<double>::max();
};

}  // namespace

nlohmann::json pose_graph(const PoseGraphBench& bench) {
  std::filesystem::create_directories(bench.out);
  Report report(bench.out);
  std::printf("pose graph: rms error of keyframes after the best rigid fit, one transform a session -> corrected\n");
  using mine::Kind;
  for (const Kind kind : {Kind::junctions, Kind::grid, Kind::varied})
    for (int i = 0; i < bench.mines; ++i)
      for (const Loop loop : {Loop::one_robot, Loop::two_robots}) {
        const double drift = 1 + i % 2;
        const std::uint64_t seed = bench.first_seed + static_cast<std::uint64_t>(i);
        const std::string name = std::string(to_string(kind)) + "-" + std::to_string(seed) + " drift " +
                                 std::to_string(i % 2 + 1) + (loop == Loop::one_robot ? ", one robot" : ", two robots");
        report.add(name, drive_loop(kind, seed, drift, loop).sessions, true);
      }
  for (const Kind kind : {Kind::straight, Kind::junctions, Kind::varied})
    for (int i = 0; i < bench.mines; ++i) {
      mine::Request request;
      request.kind = kind;
      request.seed = bench.first_seed + 100 + static_cast<std::uint64_t>(i);
      request.overlap_pct = 60;
      request.length_m = 160;
      request.drift = 2;
      report.add(std::string(to_string(kind)) + "-" + std::to_string(request.seed) + " gallery, drift 2",
                 drive_mine(request, Selection::by_spaciousness).sessions, false);
    }
  if (!bench.sets.empty())
    for (const auto& set : sets_below(bench.sets)) {
      std::vector<DrivenSession> sessions;
      for (auto& [robot, session] : sessions_of(set, {std::string(default_family_name)}))
        sessions.push_back(std::move(session));
      report.add(set.filename(), sessions, false);
    }
  nlohmann::json figures = report.figures();
  figures["scale"] = pose_graph_scale(1000, 3000);
  return figures;
}

}  // namespace headframe::bench
