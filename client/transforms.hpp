#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/session/keyframe.hpp"

namespace headframe {

/// Where every session of one component lies, as the base station told it.
struct Transforms {
  std::uint64_t revision = 0;
  std::uint64_t component = 0;
  SessionKey anchor;  // its axes are the component's
  struct Placement {
    SessionKey session;
    Pose T_component_session = Pose::Identity();
  };
  std::vector<Placement> sessions;  // all of the component

  /// Where a session of another component would lie, if merges that still wait for path were made. It may be wrong, and
  /// go again: nothing to drive by. Only with RobotConfig::provisional.
  struct Provisional {
    SessionKey session;
    Pose T_component_session = Pose::Identity();
    double probability = 0;
    double awaited_m = 0;  // path that the robots still have to come, at most
    bool operator==(const Provisional& other) const {
      return session == other.session && T_component_session.matrix() == other.T_component_session.matrix() &&
             probability == other.probability && awaited_m == other.awaited_m;
    }
  };
  std::vector<Provisional> provisional = {};

  /// A transform between two sessions that had been told and does not hold: whoever drives by it stops.
  struct Withdrawn {
    std::uint64_t revision = 0;  // the first without it
    SessionKey a, b;
    std::string reason;
  };
  std::vector<Withdrawn> withdrawn = {};  // the latest that concern this component, oldest first; also old news

  std::optional<Pose> T_component(const SessionKey& session) const {
    for (const auto& s : sessions)
      if (s.session == session) return s.T_component_session;
    return std::nullopt;
  }

  /// The other session's frame in mine: p_mine = T_mine_other * p_other. nullopt: one of them is not in the component.
  std::optional<Pose> T_mine_other(const SessionKey& mine, const SessionKey& other) const {
    const auto T_component_mine = T_component(mine), T_component_other = T_component(other);
    if (!T_component_mine || !T_component_other) return std::nullopt;
    return T_component_mine->inverse() * *T_component_other;
  }
};

}  // namespace headframe
