#pragma once

#include <cstdint>
#include <optional>
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
