#include "server/store/columns.hpp"

#include <array>
#include <bit>
#include <cstring>

namespace headframe {

static_assert(std::endian::native == std::endian::little, "blobs are written as they lie in memory");

std::string pose_blob(const Pose& T) {
  const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> m = T.matrix().topRows<3>();
  return {reinterpret_cast<const char*>(m.data()), sizeof(double) * 12};
}

Pose pose_from_blob(std::string_view blob) {
  Pose T = Pose::Identity();
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> m;
  if (blob.size() != sizeof(double) * 12) return T;
  std::memcpy(m.data(), blob.data(), blob.size());
  T.matrix().topRows<3>() = m;
  return T;
}

namespace {

constexpr std::size_t pose_bytes = sizeof(double) * 12, place_bytes = sizeof(std::uint64_t) + pose_bytes;

}  // namespace

std::string places_blob(const std::vector<CorrectedKeyframe>& places) {
  std::string out;
  for (const CorrectedKeyframe& place : places) {
    out.append(reinterpret_cast<const char*>(&place.sequence), sizeof place.sequence);
    out += pose_blob(place.T_component_session);
  }
  return out;
}

std::vector<CorrectedKeyframe> places_from_blob(std::string_view blob) {
  std::vector<CorrectedKeyframe> places;
  if (blob.size() % place_bytes != 0) return places;
  for (; !blob.empty(); blob.remove_prefix(place_bytes)) {
    CorrectedKeyframe& place = places.emplace_back();
    std::memcpy(&place.sequence, blob.data(), sizeof place.sequence);
    place.T_component_session = pose_from_blob(blob.substr(sizeof place.sequence, pose_bytes));
  }
  return places;
}

std::string like_places_blob(const std::vector<LikePlace>& places) {
  std::vector<double> numbers;
  for (const LikePlace& place : places) {
    numbers.insert(numbers.end(), place.here.begin(), place.here.end());
    numbers.insert(numbers.end(), place.there.begin(), place.there.end());
    for (const double value : {static_cast<double>(place.placement), place.likeness, place.resemblance})
      numbers.push_back(value);
    numbers.push_back(place.copy ? 1 : 0);
  }
  return {reinterpret_cast<const char*>(numbers.data()), sizeof(double) * numbers.size()};
}

std::vector<LikePlace> like_places_from_blob(std::string_view blob) {
  std::array<double, 10> n{};
  std::vector<LikePlace> places;
  if (blob.size() % sizeof n != 0) return places;
  for (; !blob.empty(); blob.remove_prefix(sizeof n)) {
    std::memcpy(n.data(), blob.data(), sizeof n);
    places.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, static_cast<std::uint32_t>(n[6]), n[7], n[8], n[9] != 0});
  }
  return places;
}

std::string floats_blob(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(float) * values.size()};
}

std::vector<float> floats_from_blob(std::string_view blob) {
  std::vector<float> values(blob.size() / sizeof(float));
  if (!values.empty()) std::memcpy(values.data(), blob.data(), values.size() * sizeof(float));
  return values;
}

std::string integers_blob(const std::vector<std::uint64_t>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(std::uint64_t) * values.size()};
}

std::vector<std::uint64_t> integers_from_blob(std::string_view blob) {
  std::vector<std::uint64_t> values(blob.size() / sizeof(std::uint64_t));
  if (!values.empty()) std::memcpy(values.data(), blob.data(), values.size() * sizeof(std::uint64_t));
  return values;
}

}  // namespace headframe
