#pragma once
// What a side of protocol v1 can do beyond its first form, as names in Hello and Welcome: README.md of
// proto/headframe/v1 lists them. So an old robot and a new server go on together, and a new robot sends nothing that an
// old server refuses.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace headframe {

inline constexpr std::size_t most_capabilities = 64;      // of one message; those behind are passed over
inline constexpr std::size_t most_capability_bytes = 32;  // of one name; a longer one is passed over

/// A robot that lists it is told of merges that still wait for path (ProvisionalTransform).
inline constexpr std::string_view provisional_capability = "provisional";

/// A robot that lists it takes the transforms of a component in pages, however many sessions it has.
inline constexpr std::string_view transform_pages_capability = "transform_pages";

/// A robot that lists it may ask where it is (Localize) a server that lists it.
inline constexpr std::string_view localize_capability = "localize";

/// A robot that lists it may ask a server that lists it what others know around it (SurroundingsRequest, MapRequest).
inline constexpr std::string_view surroundings_capability = "surroundings";

/// A robot says where it is and how it is (LiveState) to a server that lists it.
inline constexpr std::string_view live_capability = "live";

/// A robot that lists it is told how sure each transform is, and on what it rests (TransformSupport).
inline constexpr std::string_view transform_support_capability = "transform_support";

/// A robot sends clouds with intensities (cloud_codec.hpp) to a server that lists it, to others the same without.
inline constexpr std::string_view cloud_intensity_capability = "cloud_form_3";

/// A robot sends new poses of keyframes that it sent before (PoseUpdate) to a server that lists it.
inline constexpr std::string_view poses_capability = "poses";

/// What the robot library lists in its hello, and this server in its welcome.
std::vector<std::string> robot_capabilities(bool provisional);
std::vector<std::string> server_capabilities();

/// A peer's names, whatever it wrote: of at most most_capabilities, those of 1 to most_capability_bytes of a-z, 0-9 and
/// '_'. A name that this side does not know is kept, and means nothing to it. Pure and thread safe.
std::vector<std::string> usable_capabilities(const std::vector<std::string>& listed);

}  // namespace headframe
