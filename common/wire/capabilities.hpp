#pragma once
// What a side of protocol v1 can do beyond the protocol's first form, as names in Hello and Welcome; listed in the
// README.md of proto/headframe/v1. They let old robots work with new servers, and keep new robots from sending what an
// old server refuses.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace headframe {

inline constexpr std::size_t most_capabilities = 64;      // of one message; further ones are ignored
inline constexpr std::size_t most_capability_bytes = 32;  // of one name; longer ones are ignored

/// A robot that lists it is also told of merges that still wait for path (ProvisionalTransform).
inline constexpr std::string_view provisional_capability = "provisional";

/// A robot that lists it accepts the transforms of a component in pages, for any number of sessions.
inline constexpr std::string_view transform_pages_capability = "transform_pages";

/// A robot that lists it may ask a server that lists it where it is (Localize).
inline constexpr std::string_view localize_capability = "localize";

/// A robot that lists it may ask a server that lists it what others know around it (SurroundingsRequest, MapRequest).
inline constexpr std::string_view surroundings_capability = "surroundings";

/// A robot sends where it is and its condition (LiveState) to a server that lists it.
inline constexpr std::string_view live_capability = "live";

/// A robot that lists it is told how reliable each transform is, and why (TransformSupport).
inline constexpr std::string_view transform_support_capability = "transform_support";

/// A robot sends clouds with intensities (cloud_codec.hpp) to a server that lists it, and without them to others.
inline constexpr std::string_view cloud_intensity_capability = "cloud_form_3";

/// A robot sends new poses of keyframes that it sent before (PoseUpdate) to a server that lists it.
inline constexpr std::string_view poses_capability = "poses";

/// What the robot library lists in its hello, and this server in its welcome.
std::vector<std::string> robot_capabilities(bool provisional);
std::vector<std::string> server_capabilities();

/// The valid names in a peer's list: of the first most_capabilities, those of 1 to most_capability_bytes of a-z, 0-9
/// and '_'. Unknown names are kept and have no effect. Pure and thread safe.
std::vector<std::string> usable_capabilities(const std::vector<std::string>& listed);

}  // namespace headframe
