#pragma once
// What a robot asks about others, and what it holds of the answers, over all connections.

#include <array>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "client/surroundings.hpp"
#include "common/result.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// Pages in, questions and whole answers out. No I/O; not thread safe. Memory is bounded whatever the server sends.
class SurroundingsBook {
 public:
  explicit SurroundingsBook(std::size_t most_points = 4'000'000) : most_points_(most_points) {}

  void want_trajectories(bool wanted) { wants_trajectories_ = wanted; }
  void want_coverage(bool wanted) { wants_coverage_ = wanted; }
  /// In place of the map that was asked for before.
  void want_map(const MapQuestion& question);

  v1::RobotMessage trajectories_question() const;
  v1::RobotMessage coverage_question() const;
  v1::RobotMessage map_question() const;  // while a map is wanted
  /// What is to be asked on a new connection: all that stands.
  std::vector<v1::RobotMessage> questions();
  bool wants_any() const { return wants_trajectories_ || wants_coverage_ || map_.has_value(); }
  bool wants_trajectories() const { return wants_trajectories_; }
  bool wants_coverage() const { return wants_coverage_; }
  bool wants_map() const { return map_.has_value(); }
  void give_up_map() { map_.reset(); }

  using Told = std::variant<std::monostate, Trajectories, Coverage, MapAround>;
  struct Taken {
    Told told;                             // once an answer is whole
    std::optional<v1::RobotMessage> next;  // to be asked now
  };
  /// A message of the server's that holds a Trajectories, a Coverage or a MapPart. A page that does not follow what is
  /// held is passed over and all asked for anew; bad_input: what no server may send.
  Result<Taken> take(const v1::ServerMessage& message);

  static constexpr std::size_t most_sessions = 200000, most_tiles = 16384;

 private:
  struct Path {
    SessionKey session;
    double last_stamp_s = 0;
    std::optional<double> age_s;
    std::vector<std::array<std::int32_t, 3>> points;  // the component's frame, 0.1 m
    bool in = false;                                  // of the component
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
