#pragma once
// Values that are stored as blobs: little-endian numbers, bit for bit what they were.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/se3.hpp"
#include "server/atlas/correction.hpp"

namespace headframe {

std::string pose_blob(const Pose& T);
/// The identity when the blob has another size than pose_blob gives.
Pose pose_from_blob(std::string_view blob);

/// 104 bytes each: the sequence (64 bit) and T_component_session as 12 doubles.
std::string places_blob(const std::vector<CorrectedKeyframe>& places);
/// None when the blob has another size than places_blob gives.
std::vector<CorrectedKeyframe> places_from_blob(std::string_view blob);

std::string floats_blob(const std::vector<float>& values);
std::vector<float> floats_from_blob(std::string_view blob);

std::string integers_blob(const std::vector<std::uint64_t>& values);
std::vector<std::uint64_t> integers_from_blob(std::string_view blob);

}  // namespace headframe
