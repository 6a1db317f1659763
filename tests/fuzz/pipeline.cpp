// What robots that were let in can do to the whole pipeline: sessions that grow from any keyframes and clouds which the
// protocol lets in, attempts, work done ahead, decisions, and exports of what came of it. Small sessions in a small
// mine, so that an input takes milliseconds.
#include <spdlog/spdlog.h>

#include <cstring>
#include <limits>

#include "common/cloud/cloud_codec.hpp"
#include "common/wire/convert.hpp"
#include "server/merge/merge_pipeline.hpp"
#include "server/operator/map_export.hpp"
#include "server/operator/overlay.hpp"
#include "server/operator/plan.hpp"
#include "server/operator/point_tiles.hpp"
#include "server/operator/trajectory_export.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/scenario/drawn_base.hpp"
#include "tests/support/fake_station.hpp"

namespace headframe::fuzz {
namespace {

using test::BoxMine;
using test::Drive;

constexpr std::size_t most_sessions = 4, most_keyframes = 8, most_attempts = 2;
constexpr std::size_t export_every = 8;     // inputs: exports cost as much as all else, ...
constexpr std::size_t closely_every = 256;  // ... and to search walls as closely as the product a hundred times

template <class T>
T take(std::string_view& bytes) {
  T value{};
  const std::size_t n = std::min(sizeof value, bytes.size());
  std::memcpy(&value, bytes.data(), n);
  bytes.remove_prefix(n);
  return value;
}

std::string_view take_piece(std::string_view& bytes, std::size_t most) {
  const std::string_view piece = bytes.substr(0, std::min(most, bytes.size()));
  bytes.remove_prefix(piece.size());
  return piece;
}

/*  y
 *  5        |
 *           |
 *  0  ------+-----
 *     0     6    12    */
const std::vector<Drive>& drives() {
  static const std::vector<Drive> all = [] {
    const BoxMine mine({BoxMine::drift(0, 0, 12, 0, 3), BoxMine::drift(6, 0, 6, 6, 2.4)});
    std::vector<Drive> made{test::drive(mine, {{1, 0}, {11, 0}}, 0, 1, 2.5),
                            test::drive(mine, {{11, 0}, {6, 0}, {6, 5}}, 2.3, 2, 2.5)};
    for (Drive& drive : made)
      for (KeyframeCloud& cloud : drive.clouds) {
        Points few;
        for (std::size_t i = 0; i < cloud.sweeps[0].points.size(); i += 64) few.push_back(cloud.sweeps[0].points[i]);
        cloud.sweeps[0].points = few;
      }
    return made;
  }();
  return all;
}

/// Finite numbers of any size, near ones mostly.
double take_metres(std::string_view& bytes) {
  switch (take_byte(bytes) % 4) {
    case 0: return take<std::int8_t>(bytes) * 0.1;
    case 1: return take<std::int16_t>(bytes);
    case 2: return take<std::int32_t>(bytes);
    default: return take<double>(bytes);
  }
}

/// Changes of a sound keyframe as a peer could send them; each bit is one.
void change(v1::Keyframe& keyframe, std::string_view& bytes) {
  const std::uint8_t what = take_byte(bytes);
  v1::Pose& T = *keyframe.mutable_t_local_sensor();
  if ((what & 1) != 0) T.set_x(T.x() + take_metres(bytes));
  if ((what & 2) != 0) T.set_y(T.y() + take_metres(bytes));
  if ((what & 4) != 0) T.set_z(T.z() + take_metres(bytes));
  if ((what & 8) != 0) {
    T.set_qx(take<std::int8_t>(bytes));
    T.set_qy(take<std::int8_t>(bytes));
  }
  if ((what & 16) != 0) keyframe.set_walls(std::string(WallProfile::sectors, static_cast<char>(take_byte(bytes))));
  if ((what & 32) != 0) {
    std::string walls = keyframe.walls();
    const std::string_view piece = take_piece(bytes, 8);
    walls.replace(take_byte(bytes) % 160U, piece.size(), piece);
    keyframe.set_walls(walls);
  }
  if ((what & 64) != 0) keyframe.set_q(std::string(take_piece(bytes, 16)));
  if ((what & 128) != 0) keyframe.set_stamp_s(take<double>(bytes));
}

/// The sound cloud, one that decodes from a peer's bytes, many points in few places, or far points.
std::optional<KeyframeCloud> cloud_of(const KeyframeCloud& sound, std::string_view& bytes) {
  const std::uint8_t kind = take_byte(bytes) % 6;
  if (kind == 0) return std::nullopt;
  if (kind == 1) {
    auto decoded = decode_cloud(std::string(take_piece(bytes, 256)));
    return decoded ? std::optional(std::move(*decoded)) : std::nullopt;
  }
  if (kind > 3) return sound;
  KeyframeCloud cloud{{{Eigen::Vector3f::Zero(), {}}}};
  const std::size_t places = 1 + take_byte(bytes) % 4U, copies = 1 + take_byte(bytes) % 64U;
  for (std::size_t i = 0; i < places; ++i) {
    Eigen::Vector3f p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = kind == 2 ? 0.1F * take<std::int8_t>(bytes) : static_cast<float>(take_metres(bytes));
    cloud.sweeps[0].points.insert(cloud.sweeps[0].points.end(), copies, p);
  }
  const auto encoded = encode_cloud(cloud);  // what can not travel does not
  auto decoded = encoded ? decode_cloud(*encoded) : tl::unexpected(encoded.error());
  return decoded ? std::optional(std::move(*decoded)) : std::nullopt;
}

struct Told {
  std::vector<Keyframe> keyframes;
  std::size_t drive = 0;
};

/// The operator's view of a pipeline.
class PipelineStation : public FakeStation {
 public:
  PipelineStation(const MergePipeline& pipeline, const std::map<SessionId, Told>& told, test::Shelf& shelf)
      : told_(told), shelf_(shelf) {
    rows.clear();
    for (const auto& [id, session] : told) rows.push_back({id, {"robot" + std::to_string(id), "s"}, {}, {}});
    view = {pipeline.atlas(), {}};
  }
  Result<std::vector<Keyframe>> trajectory(SessionId session) const override { return told_.at(session).keyframes; }
  Result<KeyframeCloud> cloud(SessionId session, std::uint64_t sequence) const override {
    const auto found = shelf_.clouds.find({session, sequence});
    if (found == shelf_.clouds.end()) return failure(ErrorCode::not_found, "no cloud");
    return found->second;
  }

 private:
  const std::map<SessionId, Told>& told_;
  test::Shelf& shelf_;
};

void drain(BodySource&& body) {
  for (auto piece = body.next(); piece && *piece;) piece = body.next();
}

class Base {
 public:
  explicit Base(std::size_t turn) : turn_(turn), config_(small(turn % closely_every == 0)) {}

  void run(std::string_view bytes) {
    while (!bytes.empty()) step(bytes);
    for (const auto& [id, session] : told_) pipeline_.complete_session(id);
    for (const Component& component : pipeline_.atlas().components)
      for (const Placement& placement : component.placements)
        require(placement.T_component_session.matrix().allFinite());
    if (turn_ % export_every == 0) export_all(turn_ / export_every);
  }

 private:
  /// Little work for each pair; nothing waits for path, and what fits somehow is merged. closely: walls are searched as
  /// in the product.
  static MergeConfig small(bool closely) {
    MergeConfig config;
    config.threads = 1;
    config.least_path_m = 0;
    config.shown_m = 0;
    config.accept_probability = 0;
    config.runner_up_share = std::numeric_limits<double>::infinity();
    config.hypotheses = 2;
    config.searches = 1;
    if (closely) return config;
    config.placements = 3;
    config.wall_search = {.cell_m = 6, .quarter_turns = 3, .peaks = 4};
    return config;
  }

  SessionId some_session(std::string_view& bytes) {
    return 1 + take_byte(bytes) % static_cast<SessionId>(most_sessions);
  }
  AlignmentId some_alignment(std::string_view& bytes) { return 1 + take_byte(bytes) % 6; }

  void step(std::string_view& bytes) {
    switch (const std::uint8_t what = take_byte(bytes) % 16; what) {
      case 8: return pipeline_.complete_session(known(bytes));
      case 9: return attempt(known(bytes));
      case 10: return prepare_ahead(1 + take_byte(bytes) % 4);
      case 11: return (void)pipeline_.decide(some_alignment(bytes), static_cast<Decision>(take_byte(bytes) % 4));
      case 12: return (void)pipeline_.anchor(some_session(bytes));
      case 13: return set_aside_and_take_back(known(bytes));
      case 14: return restore();
      case 15: return tend(known(bytes), take_byte(bytes));
      default: return grow(bytes, what);
    }
  }

  /// A session that there is.
  SessionId known(std::string_view& bytes) {
    const SessionId id = some_session(bytes);
    if (!told_.contains(id)) begin(id);
    return id;
  }

  void begin(SessionId id) {
    told_[id].drive = static_cast<std::size_t>(id) % drives().size();
    pipeline_.add_session(id, family_.id);
  }

  /// By the next keyframe of its drive, as it is or changed, or by several as they are.
  void grow(std::string_view& bytes, std::uint8_t what) {
    const SessionId id = known(bytes);
    for (int more = what < 4 ? 4 : 1; more > 0; --more) {
      if (keyframes_ >= most_keyframes) return;
      Told& session = told_.at(id);
      const Drive& drive = drives()[session.drive];
      const std::size_t at = session.keyframes.size() % drive.keyframes.size();
      auto message = to_proto(drive.keyframes[at]).value();
      message.set_sequence(session.keyframes.size() + 1);
      if (what >= 4) change(message, bytes);
      auto keyframe = from_proto(message);
      if (!keyframe || !complete(*keyframe, family_)) return;
      auto cloud = what < 4 ? std::optional(drive.clouds[at]) : cloud_of(drive.clouds[at], bytes);
      if (cloud) shelf_.clouds[{id, keyframe->sequence}] = std::move(*cloud);
      session.keyframes.push_back(*keyframe);
      ++keyframes_;
      pipeline_.add_keyframe(id, *keyframe);
      pipeline_.prepare_cloud({id, keyframe->sequence}, shelf_);
    }
  }

  void attempt(SessionId id) {
    if (++attempts_ > most_attempts) return;
    for (int rounds = 0; rounds < 2; ++rounds)
      if (!pipeline_.attempt(id, shelf_).unfinished) return;
  }

  void tend(SessionId id, std::uint8_t what) {
    switch (what % 4) {
      case 0: return (void)pipeline_.freeze(id);
      case 1: return (void)pipeline_.thaw(id);
      case 2: return pipeline_.await_no_more(id);
      default: (void)pipeline_.ask_where(id, what % 8 == 3), (void)pipeline_.localization(id);
    }
  }

  void prepare_ahead(int times) {
    while (times-- > 0 && pipeline_.prepare_ahead(shelf_)) {
    }
  }

  void set_aside_and_take_back(SessionId id) {
    (void)pipeline_.set_aside(id);
    pipeline_.add_session(id, family_.id);
    for (const Keyframe& keyframe : told_.at(id).keyframes) pipeline_.add_keyframe(id, keyframe);
  }

  /// As the server does at its start: what was given out is taken back by a pipeline that knows the same keyframes.
  void restore() {
    MergePipeline next(config_);
    for (const auto& [id, session] : told_) {
      next.add_session(id, family_.id);
      for (const Keyframe& keyframe : session.keyframes) next.add_keyframe(id, keyframe);
    }
    next.restore(pipeline_.alignments(), pipeline_.atlas().revision);
    require(next.alignments().size() == pipeline_.alignments().size());
  }

  /// One format of points for each input, and a plan for each fourth.
  void export_all(std::size_t turn) {
    const PipelineStation station(pipeline_, told_, shelf_);
    for (const Component& component : pipeline_.atlas().components) {
      constexpr std::array formats{CloudFormat::ply, CloudFormat::pcd, CloudFormat::las};
      drain(MapExport(station, {component.id, formats[turn % formats.size()], 0.1, OutputFrame::component}));
      if (turn % 4 == 0) drain(Plan(station, {.component = component.id, .format = PlanFormat::svg, .pixel_mm = 5}));
    }
    for (const auto& [id, session] : told_) {
      drain(TrajectoryExport(station, {"robot" + std::to_string(id), "s"}));
      drain(PathJson(station, id, 1));
    }
    for (const Alignment& alignment : pipeline_.alignments()) drain(OverlayJson(station, alignment, 100));
  }

  const FamilySpec family_{ScanContext().id(), drives()[0].keyframes[0].descriptor.q.size(),
                           drives()[0].keyframes[0].descriptor.w.size()};
  const std::size_t turn_;  // a number that the input has for its own
  const MergeConfig config_;
  MergePipeline pipeline_{config_};
  test::Shelf shelf_;
  std::map<SessionId, Told> told_;
  std::size_t keyframes_ = 0, attempts_ = 0;
};

}  // namespace
}  // namespace headframe::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  spdlog::set_level(spdlog::level::off);
  (void)headframe::fuzz::drives();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = headframe::fuzz::text(data, size);
  headframe::fuzz::Base(std::hash<std::string_view>{}(bytes)).run(bytes);
  return 0;
}
