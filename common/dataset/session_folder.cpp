#include "common/dataset/session_folder.hpp"

#include <algorithm>
#include <string_view>

#include "common/dataset/sensor_file.hpp"
#include "common/dataset/text.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_poses_bytes = std::uintmax_t{256} << 20;  // two days at 10 Hz
constexpr std::uintmax_t most_sensor_bytes = std::uintmax_t{64} << 10;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// The digits at the start without leading zeros; removes them all from rest.
std::string_view take_number(std::string_view& rest) {
  std::size_t end = 0;
  while (end < rest.size() && is_digit(rest[end])) ++end;
  std::string_view digits = rest.substr(0, end);
  rest.remove_prefix(end);
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

// Sorts by name, but numbers by value, because a recorder that writes 9.bin, 10.bin means this order.
bool before(const fs::path& path_a, const fs::path& path_b) {
  const std::string name_a = path_a.filename().string();
  const std::string name_b = path_b.filename().string();
  std::string_view a = name_a;
  std::string_view b = name_b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a[0]) && is_digit(b[0])) {
      const std::string_view number_a = take_number(a);
      const std::string_view number_b = take_number(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
      continue;
    }
    if (a[0] != b[0]) return a[0] < b[0];
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return name_a < name_b;  // 01 and 1
}

tl::unexpected<Error> in_file(const fs::path& file, const Error& error) {
  return failure(error.code, file.string() + ": " + error.message);
}

}  // namespace

Result<SessionFolder> SessionFolder::open(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error))
    return failure(ErrorCode::not_found,
                   path.string() + ": no such folder; a session folder holds scans/ and poses.txt");
  SessionFolder folder;
  Result<void> done = folder.read_poses(path / "poses.txt");
  if (done) done = folder.find_scans(path / "scans");
  if (done) done = folder.read_sensor(path / "sensor.json");
  if (!done) return tl::unexpected(done.error());
  if (folder.poses_.size() != folder.scans_.size())
    return failure(ErrorCode::bad_input, path.string() + ": " + std::to_string(folder.poses_.size()) +
                                             " poses in poses.txt but " + std::to_string(folder.scans_.size()) +
                                             " scans in scans/; there must be one pose a scan");
  return folder;
}

Result<void> SessionFolder::find_scans(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return failure(ErrorCode::not_found, folder.string() + ": no such folder");
  std::size_t others = 0;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    if (is_scan_file(entry->path()))
      scans_.push_back(entry->path());
    else
      ++others;
  }
  if (error) return failure(ErrorCode::unavailable, folder.string() + ": cannot be listed: " + error.message());
  if (others > 0)
    warnings_.push_back(folder.string() + ": passed over " + std::to_string(others) +
                        " files that are not .bin, .pcd or .ply");
  std::sort(scans_.begin(), scans_.end(), before);
  return {};
}

Result<void> SessionFolder::read_poses(const fs::path& file) {
  const auto text = dataset::read_file(file, most_poses_bytes);
  if (!text) return tl::unexpected(text.error());
  auto poses = dataset::parse_poses(*text);
  if (!poses) return in_file(file, poses.error());
  if (poses->empty()) return failure(ErrorCode::bad_input, file.string() + ": no poses in it");
  poses_ = *std::move(poses);
  return {};
}

Result<void> SessionFolder::read_sensor(const fs::path& file) {
  const auto text = dataset::read_file(file, most_sensor_bytes);
  if (!text && text.error().code == ErrorCode::not_found) {
    sensor_ = dataset::default_sensor();
    warnings_.push_back(file.string() + ": not there, taken as 32 beams, 22.5 deg up and down, 100 m");
    return {};
  }
  if (!text) return tl::unexpected(text.error());
  auto read = dataset::parse_sensor(*text);
  if (!read) return in_file(file, read.error());
  sensor_ = read->sensor;
  for (const auto& warning : read->warnings) warnings_.push_back(file.string() + ": " + warning);
  return {};
}

}  // namespace headframe
