#pragma once
// Limits that both sides enforce, checked before memory is allocated.

#include <cstddef>

namespace headframe::limits {

inline constexpr std::size_t frame_bytes = 256 * 1024;        // payload of one frame
inline constexpr std::size_t chunk_bytes = 8 * 1024;          // cloud bytes in one CloudChunk
inline constexpr std::size_t cloud_bytes = 16 * 1024 * 1024;  // one encoded cloud
inline constexpr std::size_t cloud_points = 4'000'000;        // one decoded cloud
inline constexpr std::size_t cloud_sweeps = 256;              // one decoded cloud
inline constexpr std::size_t descriptor_floats = 4096;        // q or w
inline constexpr std::size_t name_bytes = 128;                // robot, session, family, sensor model
inline constexpr std::size_t health_bytes = 256;              // what a robot says of its health
inline constexpr std::size_t update_poses = 100'000;          // one PoseUpdate, in all its messages
inline constexpr std::size_t part_poses = 1024;               // one message of it
inline constexpr std::size_t spool_runs = 64;                 // of one hello
inline constexpr double position_m = 1e8;                     // each axis of a pose; survey grids reach 1e7

}  // namespace headframe::limits
