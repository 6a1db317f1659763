#pragma once

#include "headframe/v1/robot.pb.h"
#include "server/surroundings/component_maps.hpp"

namespace headframe {

// What robots are told of others, as messages. Pure and thread safe.

/// Of a session in no component of several, and with what else there is nothing to tell: why.
v1::SurroundingsPage nothing_to_tell(const HeldVersion& held, const std::string& why);

/// now_s: the time of day, for ages.
v1::Trajectories trajectories_page(const SessionSurroundings& around, const HeldVersion& held,
                                   const ComponentMaps::Known& known, const ComponentMap::Piece& piece, double now_s);
v1::Coverage coverage_page(const SessionSurroundings& around, const HeldVersion& held,
                           const ComponentMaps::Known& known, const ComponentMap::Piece& piece, double now_s);

/// A map's first part, without any of its data.
v1::MapPart map_head(std::uint64_t id, std::uint64_t revision, const ComponentMaps::MapAnswer& answer);

}  // namespace headframe
