#include "server/store/constraint_blob.hpp"

#include <array>
#include <cstring>

#include "server/store/columns.hpp"

namespace headframe {
namespace {

constexpr std::size_t pose_bytes = 12 * sizeof(double);

struct Numbers {
  std::array<std::int64_t, 4> keyframes;
  std::array<double, 21> information;
};
constexpr std::size_t constraint_bytes = sizeof(Numbers) + pose_bytes;

}  // namespace

std::string constraints_blob(const PoseConstraints& constraints) {
  std::string out;
  if (!constraints) return out;
  for (const PoseConstraint& c : *constraints) {
    Numbers numbers{{c.from.session, static_cast<std::int64_t>(c.from.sequence), c.to.session,
                     static_cast<std::int64_t>(c.to.sequence)},
                    {}};
    std::size_t n = 0;
    for (Eigen::Index row = 0; row < 6; ++row)
      for (Eigen::Index column = row; column < 6; ++column) numbers.information.at(n++) = c.information(row, column);
    out.append(reinterpret_cast<const char*>(&numbers), sizeof numbers);
    out += pose_blob(c.T_from_to);
  }
  return out;
}

PoseConstraints constraints_from_blob(std::string_view blob) {
  if (blob.empty() || blob.size() % constraint_bytes != 0) return nullptr;
  std::vector<PoseConstraint> out;
  for (; !blob.empty(); blob.remove_prefix(constraint_bytes)) {
    Numbers numbers;
    std::memcpy(&numbers, blob.data(), sizeof numbers);
    PoseConstraint& c = out.emplace_back();
    c.from = {numbers.keyframes[0], static_cast<std::uint64_t>(numbers.keyframes[1])};
    c.to = {numbers.keyframes[2], static_cast<std::uint64_t>(numbers.keyframes[3])};
    std::size_t n = 0;
    for (Eigen::Index row = 0; row < 6; ++row)
      for (Eigen::Index column = row; column < 6; ++column)
        c.information(row, column) = c.information(column, row) = numbers.information.at(n++);
    c.T_from_to = pose_from_blob(blob.substr(sizeof numbers, pose_bytes));
  }
  return std::make_shared<const std::vector<PoseConstraint>>(std::move(out));
}

}  // namespace headframe
