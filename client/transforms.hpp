#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// The frame of every session of one component, as the base station reported it.
struct Transforms {
  std::uint64_t revision = 0;
  std::uint64_t component = 0;
  SessionKey anchor;  // its local frame is the component's frame

  /// How reliable a placement is: along the most reliable chain of merges from the anchor to the session, which is the
  /// chain whose least probable merge is the most probable.
  struct Support {
    double probability = 0;                                // of the least probable merge on the chain
    std::optional<SessionKey> merged_with = std::nullopt;  // the one before it on the chain; nullopt: it is the anchor
    std::uint32_t merges = 0;                              // number of merges of the session
    double shared_m = 0;                                   // path shared with merged_with
    bool confirmed = false;                                // the operator confirmed the merge with merged_with
    double deviation_m = 0;  // standard deviation on each axis, for rock along that shared path, relative to the anchor
    double deviation_rad = 0;  // the same about each axis

    /// For a place of the session that lies `away_m` (in the component's axes) from the shared path: x, y, z in metres,
    /// then rotations about the component's axes x, y, z in radians. Does not include drift within sessions.
    Eigen::Matrix<double, 6, 6> covariance(const Eigen::Vector3d& away_m = Eigen::Vector3d::Zero()) const;
  };

  struct Placement {
    SessionKey session;
    Pose T_component_session = Pose::Identity();
    std::optional<Support> support = std::nullopt;  // nullopt: the base station is older, or no merge connects it
  };
  std::vector<Placement> sessions;  // all of the component

  /// Where a session of another component would lie if merges that still wait for path were made. It may be wrong and
  /// may disappear again, so do not drive by it. Only with RobotConfig::provisional.
  struct Provisional {
    SessionKey session;
    Pose T_component_session = Pose::Identity();
    double probability = 0;
    double awaited_m = 0;  // longest path that robots still have to drive
    bool operator==(const Provisional& other) const {
      return session == other.session && T_component_session.matrix() == other.T_component_session.matrix() &&
             probability == other.probability && awaited_m == other.awaited_m;
    }
  };
  std::vector<Provisional> provisional = {};

  /// A transform between two sessions that was reported and no longer holds: stop relying on it.
  struct Withdrawn {
    std::uint64_t revision = 0;  // the first revision without it
    SessionKey a, b;
    std::string reason;
  };
  std::vector<Withdrawn> withdrawn = {};  // the latest ones in this component, oldest first; may repeat known ones

  std::optional<Pose> T_component(const SessionKey& session) const {
    for (const auto& s : sessions)
      if (s.session == session) return s.T_component_session;
    return std::nullopt;
  }

  /// Null if nothing is known of it.
  const Support* support(const SessionKey& session) const {
    for (const auto& s : sessions)
      if (s.session == session && s.support) return &*s.support;
    return nullptr;
  }

  /// The other session's frame in mine: p_mine = T_mine_other * p_other. Nullopt if one of them is not in the
  /// component.
  std::optional<Pose> T_mine_other(const SessionKey& mine, const SessionKey& other) const {
    const auto T_component_mine = T_component(mine), T_component_other = T_component(other);
    if (!T_component_mine || !T_component_other) return std::nullopt;
    return T_component_mine->inverse() * *T_component_other;
  }
};

}  // namespace headframe
