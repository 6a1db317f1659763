#pragma once
// Values that are stored as blobs: numbers in little-endian order, preserved bit for bit.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/se3.hpp"
#include "server/atlas/correction.hpp"
#include "server/session/self_likeness.hpp"

namespace headframe {

std::string pose_blob(const Pose& T);
/// Returns the identity if the blob does not have the size that pose_blob gives.
Pose pose_from_blob(std::string_view blob);

/// 104 bytes for each place: the sequence (64 bit) and T_component_session as 12 doubles.
std::string places_blob(const std::vector<CorrectedKeyframe>& places);
/// Empty if the blob does not have a size that places_blob gives.
std::vector<CorrectedKeyframe> places_from_blob(std::string_view blob);

std::string floats_blob(const std::vector<float>& values);
std::vector<float> floats_from_blob(std::string_view blob);

/// See LikePlace; empty if the blob does not have a size that like_places_blob gives.
std::string like_places_blob(const std::vector<LikePlace>& places);
std::vector<LikePlace> like_places_from_blob(std::string_view blob);

std::string integers_blob(const std::vector<std::uint64_t>& values);
std::vector<std::uint64_t> integers_from_blob(std::string_view blob);

}  // namespace headframe
