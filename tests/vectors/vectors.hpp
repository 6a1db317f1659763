#pragma once
// The protocol's test vectors (proto/headframe/v1/vectors), made by the code that the product runs.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/cloud/point_cloud.hpp"
#include "common/geometry/se3.hpp"

namespace headframe::vectors {

using Json = nlohmann::ordered_json;

/// One file: its name without ".json", and what it holds.
struct File {
  std::string name;
  Json content;
};

std::vector<File> link_files();   // frames, names, enrolments, what a server answers to messages
std::vector<File> place_files();  // keyframes: selection, levelled frame, wall profile, Scan Context, halves
std::vector<File> cloud_files();  // sweeps and their code
std::vector<File> all_files();

/// As it is written: one element a line, so that a change can be read.
std::string to_text(const Json& content);

/// Where two contents differ, as a JSON pointer and both values; empty: nowhere. Numbers may differ by 1e-5 of their
/// size (and 1e-6), since compilers round floats differently; everything else is exact.
std::string difference(const Json& a, const Json& b);

/// Points whose coordinates are whole millimetres, so that they read well and are the same in every language.
Json to_json(const Points& points);
Json to_json(const Pose& T);  // x y z qx qy qz qw

/// A room of 6 x 5 m with a floor at -1.2 m and a roof at 2.1 m around the sensor, and a pillar ahead to the left.
Points room_scan(int columns, int beams);

}  // namespace headframe::vectors
