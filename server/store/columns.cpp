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
