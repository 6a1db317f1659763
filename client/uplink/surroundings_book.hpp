#pragma once
// The robot's questions about what others know, and its copy of the answers, across connections.

#include <array>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "client/surroundings.hpp"
#include "common/result.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// Takes pages, returns questions and complete answers. No I/O; not thread safe. Memory is bounded whatever the server
/// sends.
class SurroundingsBook {
 public:
  explicit SurroundingsBook(std::size_t most_points = 4'000'000) : most_points_(most_points) {}

  void want_trajectories(bool wanted) { wants_trajectories_ = wanted; }
  void want_coverage(bool wanted) { wants_coverage_ = wanted; }
  /// Replaces the map that was requested before.
  void want_map(const MapQuestion& question);

  v1::RobotMessage trajectories_question() const;
  v1::RobotMessage coverage_question() const;
  v1::RobotMessage map_question() const;  // only while a map is wanted
  /// The questions to ask on a new connection: all that are open.
  std::vector<v1::RobotMessage> questions();
  bool wants_any() const { return wants_trajectories_ || wants_coverage_ || map_.has_value(); }
  bool wants_trajectories() const { return wants_trajectories_; }
  bool wants_coverage() const { return wants_coverage_; }
  bool wants_map() const { return map_.has_value(); }
  void give_up_map() { map_.reset(); }

  using Told = std::variant<std::monostate, Trajectories, Coverage, MapAround>;
  struct Taken {
    Told told;                             // set when an answer is complete
    std::optional<v1::RobotMessage> next;  // to be sent now
  };
  /// Takes a server message that holds a Trajectories, a Coverage or a MapPart. A page that does not continue the copy
  /// is dropped, and everything is requested again. bad_input: a message that no server may send.
  Result<Taken> take(const v1::ServerMessage& message);

  static constexpr std::size_t most_sessions = 200000, most_tiles = 16384;

 private:
  struct Path {
    SessionKey session;
    double last_stamp_s = 0;
    std::optional<double> age_s;
    std::vector<std::array<std::int32_t, 3>> points;  // the component's frame, 0.1 m
    bool in = false;                                  // whether it is in the component
  };
  struct Asked {
    MapQuestion question;
    std::uint64_t id = 0;
    std::optional<v1::MapPart> head;
    std::string bytes;
  };

  Result<Taken> take(const v1::Trajectories& message);
  Result<Taken> take(const v1::Coverage& message);
  Result<Taken> take(const v1::MapPart& message);
  Result<bool> add_path(const v1::PathPart& part);
  Trajectories whole_trajectories() const;
  const std::size_t most_points_;  // of all paths
  bool wants_trajectories_ = false, wants_coverage_ = false;
  HeldVersion trajectories_held_, coverage_held_;
  Trajectories trajectories_;  // without the paths
  std::map<std::uint64_t, Path> paths_;
  std::size_t points_ = 0;
  Coverage coverage_;
  std::optional<Asked> map_;
  std::uint64_t maps_ = 0;
};

}  // namespace headframe
